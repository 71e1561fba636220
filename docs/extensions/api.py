"""Write a page for each module of ``bench.analysis`` with the public functions that it defines."""

from __future__ import annotations

import inspect
from importlib import import_module
from pathlib import Path

from sphinx.application import Sphinx

from extensions.pages import write


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the pages when the build begins."""
    app.connect("builder-inited", lambda app: write(Path(app.srcdir) / "reference" / "analysis", pages()))
    return {"parallel_read_safe": True}


def pages() -> dict[str, str]:
    """Return the page of each module, by its name; values that are no functions or classes have a page of their own."""
    from bench import analysis

    homes: dict[str, list[str]] = {}
    for name in analysis.__all__:
        thing = getattr(analysis, name)
        named = inspect.isroutine(thing) or inspect.isclass(thing)
        homes.setdefault(inspect.unwrap(thing).__module__ if named else "", []).append(name)
    return {home.rpartition(".")[2] or "constants": page(home, names) for home, names in sorted(homes.items())}


def page(home: str, names: list[str]) -> str:
    """Return the page of a module: the first sentence about it, and the names that it defines."""
    about = (inspect.getdoc(import_module(home)) or "").partition("\n\n")[0] if home else "Levels and limits."
    title = " ".join(about.replace("``", "`").split()).removesuffix(".")
    entries = "\n\n".join(_entry(home, name) for name in names)
    return f"# {title}\n\n```{{eval-rst}}\n.. currentmodule:: bench.analysis\n\n{entries}\n```\n"


def _entry(home: str, name: str) -> str:
    from bench import analysis

    kind = "autoclass" if inspect.isclass(getattr(analysis, name)) else "autofunction" if home else "autodata"
    members = "\n   :members:" if kind == "autoclass" else ""
    return f".. {kind}:: bench.analysis.{name}{members}"
