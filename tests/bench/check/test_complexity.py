"""The complexity of the CEC competitions: what is timed, and the relation of the numbers."""

from dataclasses import dataclass

import pytest

from bench import Optimizer
from bench.check.complexity import complexities, of_function
from bench.check.problems import classic

DIMENSION = 3


@dataclass(frozen=True)
class Sevens(Optimizer):
    """Asks for seven points a call, until a number of evaluations."""

    most: int = 10**9

    def minimize(self, objective, rng):
        while objective.budget - objective.remaining < self.most:
            objective(rng.uniform(objective.lower, objective.upper, (7, objective.dimension)))


@pytest.fixture
def problem():
    return classic("sphere", DIMENSION, moved=False)


def test_t1_has_as_many_evaluations_and_points_a_call_as_the_optimizer(problem):
    table = complexities({"sevens": Sevens()}, {"p": problem}, evaluations=700, runs=2)
    (row,) = table.to_dict("records")
    assert (row["problem"], row["dimension"], row["optimizer"]) == ("p", DIMENSION, "sevens")
    assert (row["evaluations"], row["points"]) == (700, 7)
    assert len(problem.points) == 700 * 4  # a warm-up, two runs, and the function by itself
    assert row["complexity"] == (row["T2"] - row["T1"]) / row["T0"]
    assert row["T0"] > 0


def test_an_optimizer_that_ends_early_is_compared_with_as_many_evaluations(problem):
    table = complexities({"short": Sevens(most=70)}, {"p": problem}, evaluations=700, runs=1)
    assert table["evaluations"].tolist() == [70]
    assert len(problem.points) == 70 * 3


def test_the_last_call_of_the_function_has_the_rest(problem):
    assert of_function(problem, evaluations=10, at_once=4) >= 0
    assert len(problem.points) == 10
