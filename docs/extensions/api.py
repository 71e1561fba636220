"""Write a page for each module of ``bench.analysis`` with the public functions that it defines."""

from __future__ import annotations

import inspect
from importlib import import_module
from pathlib import Path

from sphinx.application import Sphinx

from extensions.pages import code, table, write


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the pages when the build begins."""
    app.connect("builder-inited", lambda app: write(Path(app.srcdir) / "reference" / "analysis", pages()))
    return {"parallel_read_safe": True}


def pages() -> dict[str, str]:
    """Return the page of each module, by its name; values that are no functions or classes have a page of their own."""
    from bench import analysis

    homes: dict[str, list[str]] = {}
    values = []
    for name in analysis.__all__:
        thing = getattr(analysis, name)
        if inspect.isroutine(thing) or inspect.isclass(thing):
            homes.setdefault(inspect.unwrap(thing).__module__, []).append(name)
        else:
            values.append((code(name), code(" ".join(str(thing).split()))))
    constants = f"# Constants\n\n{table(('name of `bench.analysis`', 'value'), values)}\n"
    written = {home.rpartition(".")[2]: page(home, names) for home, names in homes.items()}
    return written | {"constants": constants}


def page(home: str, names: list[str]) -> str:
    """Return the page of a module: the first sentence about it, and the names that it defines."""
    about = (inspect.getdoc(import_module(home)) or "").partition("\n\n")[0]
    title = " ".join(about.replace("``", "`").split()).removesuffix(".")
    entries = "\n\n".join(map(_entry, names))
    return f"# {title}\n\n```{{eval-rst}}\n.. currentmodule:: bench.analysis\n\n{entries}\n```\n"


def _entry(name: str) -> str:
    from bench import analysis

    members = "autoclass", "\n   :members:"
    kind, options = members if inspect.isclass(getattr(analysis, name)) else ("autofunction", "")
    return f".. {kind}:: bench.analysis.{name}{options}"
