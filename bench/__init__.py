"""A benchmarking harness for comparing metaheuristics.

The harness knows problems and optimizers only by their two contracts, :class:`Problem` and :class:`Optimizer`, and
finds them by entry point. ``bench.solve`` runs one optimizer once; ``bench.run`` runs a study; ``bench.load_results``
reads what it wrote; ``bench.write_report`` makes tables, figures and a page of it.
"""

from bench.errors import BenchError
from bench.objective import BudgetExhausted, Objective, Trace
from bench.optimizer import Optimizer, parameter
from bench.plugins import load_optimizer, load_problem
from bench.problem import FunctionProblem, Problem
from bench.results import Results, load_results
from bench.runner import run
from bench.study import Study
from bench.trial import Result, solve

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
    "load_optimizer",
    "load_problem",
    "load_results",
    "parameter",
    "run",
    "solve",
]
