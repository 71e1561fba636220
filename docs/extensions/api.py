"""Write the pages on Python: the public names by what they are for, and those of each module of ``bench.analysis``."""

from __future__ import annotations

import inspect
from importlib import import_module
from pathlib import Path
from pydoc import locate

from sphinx.application import Sphinx

from extensions.pages import code, table, write

PUBLIC = {
    "run": "bench.compare bench.solve bench.run bench.Listener bench.Outcome bench.Study bench.study.rules.Rules "
    "bench.Result bench.trial.trial.Usage bench.trial.trial.Cost",
    "read results": "bench.load_results bench.Results bench.results.results.StoredResults "
    "bench.comparison.notebook.Plots bench.write_report",
    "load and check plug-ins": "bench.list_optimizers bench.list_problems bench.load_optimizer bench.load_problem "
    "bench.check_optimizer bench.Checkup bench.Verdict bench.testing bench.BenchError bench.WorkerDiedError",
    "judge generated optimizers": "bench.Evaluator bench.evaluator.Found bench.evaluator.Final",
    "an optimizer": "bench.Optimizer bench.parameter bench.AskTell bench.contract.optimizer.Search bench.Objective "
    "bench.Trace bench.BudgetExhausted",
    "a problem": "bench.Problem bench.FunctionProblem bench.Grid bench.contract.families",
    "a section of a report": "bench.report bench.topics",
    "helpers of plug-ins": "bench.contract.typing bench.helpers.errors bench.contract.numbers "
    "bench.contract.seeds bench.helpers bench.sandbox.callers",
}
"""The public names, or modules of them, by the title of their page."""

MEMBERS = {  # of modules that define other names, too
    "bench.contract.families": "\n   :exclude-members: Grid",
    "bench.helpers.errors": "\n   :exclude-members: BenchError",
    "bench.contract.seeds": " trial_seed",
    "bench.sandbox.callers": " Callers, Call",
    "bench.topics": " Findings, repairing",
    "bench.AskTell": " start",
    "bench.Evaluator": "\n   :special-members: __call__",
}


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the pages when the build begins."""
    app.connect("builder-inited", lambda app: _write(Path(app.srcdir) / "reference"))
    return {"parallel_read_safe": True}


def _write(reference: Path) -> None:
    write(reference / "analysis", pages())
    write(reference / "python", {title.replace(" ", "-"): public(title, names) for title, names in PUBLIC.items()})


def public(title: str, names: str) -> str:
    """Return the page of some public names, those of whole modules included."""
    entries = "\n\n".join(map(_public, names.split()))
    return f"# {title.capitalize()}\n\n```{{eval-rst}}\n.. currentmodule:: bench\n\n{entries}\n```\n"


def _public(name: str) -> str:
    thing = locate(name)
    if inspect.ismodule(thing):
        imported = "\n   :imported-members:" if hasattr(thing, "__all__") and name not in MEMBERS else ""
        return f".. automodule:: {name}\n   :members:{MEMBERS.get(name, '')}{imported}"
    if not inspect.isclass(thing):
        return f".. autofunction:: {name}"
    kind = "autoexception" if issubclass(thing, BaseException) else "autoclass"
    return f".. {kind}:: {name}\n   :members:{MEMBERS.get(name, '')}"


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
