"""What ``bench solve`` prints of plug-ins with hostile texts and functions: a search that has ended is not lost."""

import pytest

OPTIMIZER = """
from dataclasses import dataclass
from bench import Optimizer

@dataclass(frozen=True)
class Markup(Optimizer):
    def minimize(self, objective, rng):
        objective(objective.initial(4))
        objective.stop("[/tol] [bold]done")

@dataclass(frozen=True)
class Early(Optimizer):
    def minimize(self, objective, rng):
        objective(objective.initial(10))
"""
PROBLEM = """
import numpy as np
from bench import Problem

class Vague(Problem):
    name, optimum = "vague", None
    variables = ("[/a]", "b")
    lower, upper = np.full(2, -1.0), np.full(2, 1.0)

    def evaluate(self, x):
        return (x**2).sum(axis=1)

    def describe(self, x):
        raise RuntimeError("no figures")

class Crashing(Vague):
    def evaluate(self, x):
        raise RuntimeError("no mass")
"""


@pytest.fixture
def solve(bench_here, tmp_path):
    (tmp_path / "o.py").write_text(OPTIMIZER)
    (tmp_path / "p.py").write_text(PROBLEM)
    return lambda problem, optimizer: bench_here("solve", problem, f"o.py:{optimizer}", "--budget", 20, cwd=tmp_path)


def test_a_problem_that_raises_is_blamed_and_no_optimizer(solve):
    done = solve("p.py:Crashing", "Markup")
    assert done.returncode == 1
    assert "p.py:Crashing failed: RuntimeError: no mass" in " ".join(done.stderr.split())
    assert "Markup" not in done.stderr


def test_a_best_point_that_cannot_be_described_is_printed_with_a_warning(solve):
    with pytest.warns(UserWarning, match="vague does not describe its best point: RuntimeError: no figures"):
        done = solve("p.py:Vague", "Markup")
    assert done.returncode == 0
    assert "best value" in done.stdout
    assert "[/a]" in done.stdout


def test_a_return_before_the_budget_without_a_reason_is_no_success(solve):
    done = solve("sphere-2", "Early")
    assert done.returncode == 1
    assert "10 (stopped by: undeclared)" in done.stdout  # what it found is not lost
    assert "returned before the budget was spent and declared no reason" in " ".join(done.stderr.split())
