"""A benchmarking harness for comparing metaheuristics.

The harness knows problems and optimizers only by their two contracts, :class:`Problem` and :class:`Optimizer`, and
finds them by entry point. ``bench.solve`` runs one optimizer once; ``bench.run`` runs a study; ``bench.load_results``
reads what it wrote; ``bench.write_report`` makes tables, figures and a page of it. ``bench.analysis`` and
``bench.plots`` hold the statistics and figures one by one, for notebooks.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from bench.errors import BenchError
from bench.objective import BudgetExhausted, Objective, Trace
from bench.optimizer import Optimizer, parameter
from bench.plugins import load_optimizer, load_problem
from bench.problem import FunctionProblem, Problem
from bench.runner import run
from bench.study import Study
from bench.trial import Result, solve

if TYPE_CHECKING:
    from bench.check import check_optimizer
    from bench.report import write_report
    from bench.results import Results, load_results

__all__ = [
    "BenchError",
    "BudgetExhausted",
    "FunctionProblem",
    "Objective",
    "Optimizer",
    "Problem",
    "Result",
    "Results",
    "Study",
    "Trace",
    "check_optimizer",
    "load_optimizer",
    "load_problem",
    "load_results",
    "parameter",
    "run",
    "solve",
    "write_report",
]

# Only checks, reading results and reporting need pandas and matplotlib, whose import takes longer than many a trial.
_ON_DEMAND = {
    "Results": "bench.results", "check_optimizer": "bench.check", "load_results": "bench.results",
    "write_report": "bench.report",
}  # fmt: skip


def __dir__() -> list[str]:
    """Name what is imported on demand too, so that it completes in a notebook."""
    return sorted([*__all__, "analysis", "plots"])


def __getattr__(name: str) -> Any:
    """Import what is needed on demand."""
    if name in _ON_DEMAND:
        return getattr(import_module(_ON_DEMAND[name]), name)
    if name in ("analysis", "plots"):
        return import_module(f"bench.{name}")
    raise AttributeError(f"module 'bench' has no attribute {name!r}")
