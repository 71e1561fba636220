"""A benchmarking harness for comparing metaheuristics.

The harness knows problems and optimizers only by their two contracts, :class:`Problem` and :class:`Optimizer`, and
finds them by entry point. ``bench.solve`` runs one optimizer once; ``bench.run`` runs a study; ``bench.load_results``
reads its results; ``bench.write_report`` writes a page, tables and figures. ``bench.analysis`` and ``bench.plots`` hold
the single statistics and figures, for notebooks.
"""

from __future__ import annotations

from importlib import import_module

TYPE_CHECKING = False  # `python -m bench` would import a file typing.py of the working folder before __main__ runs
if TYPE_CHECKING:
    from typing import Any

    __version__: str

    from bench.check import Checkup, Verdict, check_optimizer, check_problem
    from bench.comparison.compare import compare
    from bench.comparison.notebook import Results
    from bench.contract.families import Grid
    from bench.contract.objective import Objective, Trace
    from bench.contract.optimizer import Optimizer, parameter
    from bench.contract.problem import FunctionProblem, Problem
    from bench.evaluator import Evaluator
    from bench.execution.plan import Listener
    from bench.execution.runner import Outcome, run
    from bench.execution.solve import solve
    from bench.execution.supervisor import WorkerDiedError
    from bench.helpers.errors import BenchError, BudgetExhausted, StopRun
    from bench.plugins.loading import list_optimizers, load_optimizer, load_problem
    from bench.plugins.selection import list_problems
    from bench.results.results import load_results
    from bench.study import Study
    from bench.topics import write_report
    from bench.trial.trial import Result

__all__ = [
    "AskTell",
    "BenchError",
    "BudgetExhausted",
    "Checkup",
    "Evaluator",
    "FunctionProblem",
    "Grid",
    "Listener",
    "Objective",
    "Optimizer",
    "Outcome",
    "Problem",
    "Result",
    "Results",
    "StopRun",
    "Study",
    "Trace",
    "Verdict",
    "WorkerDiedError",
    "check_optimizer",
    "check_problem",
    "compare",
    "list_optimizers",
    "list_problems",
    "load_optimizer",
    "load_problem",
    "load_results",
    "parameter",
    "run",
    "solve",
    "write_report",
]

# Every name is imported at its first use: importing pandas or numba takes longer than many commands.
_HOMES = {
    name: home
    for home, names in {
        "check": "Checkup Verdict check_optimizer check_problem",
        "comparison.compare": "compare",
        "comparison.notebook": "Results",
        "contract.families": "Grid",
        "contract.objective": "Objective Trace",
        "contract.optimizer": "AskTell Optimizer parameter",
        "contract.problem": "FunctionProblem Problem",
        "evaluator": "Evaluator",
        "execution.plan": "Listener",
        "execution.runner": "Outcome run",
        "execution.solve": "solve",
        "execution.supervisor": "WorkerDiedError",
        "helpers.errors": "BenchError BudgetExhausted StopRun",
        "plugins.loading": "list_optimizers load_optimizer load_problem",
        "plugins.selection": "list_problems",
        "results.results": "load_results",
        "study": "Study",
        "topics": "write_report",
        "trial.trial": "Result",
    }.items()
    for name in names.split()
}
_PACKAGES = ("analysis", "plots")


def __dir__() -> list[str]:
    """List the names imported on demand, so that they complete in a notebook."""
    return sorted([*__all__, *_PACKAGES])


def __getattr__(name: str) -> Any:
    """Import a public name or package at its first use."""
    if name in _HOMES:
        value = getattr(import_module(f"bench.{_HOMES[name]}"), name)
        globals()[name] = value
        return value
    if name == "__version__":
        return import_module("bench.plugins.registry").own().version
    if name in _PACKAGES:
        return import_module(f"bench.{name}")
    raise AttributeError(f"module 'bench' has no attribute {name!r}")
