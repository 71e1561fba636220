"""The names that ``import bench`` promises, and what importing it costs."""

import inspect
import re
import subprocess
import sys

import bench

NAMES = [
    "AskTell", "BenchError", "BudgetExhausted", "Checkup", "Evaluator", "FunctionProblem", "Grid", "Listener",
    "Objective", "Optimizer", "Outcome", "Problem", "Result", "Results", "StopRun", "Study", "Trace",
    "Verdict", "WorkerDiedError", "check_optimizer", "check_problem", "compare", "list_optimizers",
    "list_problems", "load_optimizer", "load_problem", "load_results", "parameter", "run", "solve",
    "write_report",
]  # fmt: skip


def test_the_public_names_are_these():
    assert bench.__all__ == NAMES


def test_the_import_alone_loads_none_of_the_large_libraries():
    code = "import bench, sys; print(*({'numpy', 'pandas', 'matplotlib', 'numba', 'scipy'} & {*sys.modules}))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_the_signatures_of_public_functions_say_what_they_take_and_return():
    functions = [each for each in map(bench.__getattr__, NAMES) if inspect.isfunction(each)]
    assert len(functions) == 12
    vague = [
        (each.__name__, name)
        for each in functions
        for name, annotation in inspect.get_annotations(each).items()
        if re.search(r"\bAny\b", str(annotation))
    ]
    assert vague == []
