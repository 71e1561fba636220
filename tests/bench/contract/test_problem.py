"""The contract of a problem, and a user's own function as a problem."""

import numpy as np
import pytest

from bench import BenchError, FunctionProblem, Problem
from bench.contract.problem import with_own_box


def plane(lower=(-1, 0), upper=(1, 4), **options):
    return FunctionProblem(lambda x: x.sum(axis=1), lower, upper, **options)


A = np.diag([1.0, 2.0, 3.0, 4.0])


def value(x):
    """What every function below is worth at the (n, 2 to 4) points."""
    return (x**2 @ np.arange(1, x.shape[1] + 1)).tolist()


def one_by_one(x):
    return [sum((j + 1) * float(row[j]) ** 2 for j in range(len(row))) for row in x]


def unpacked(x):
    a, b, *others = (float(each) ** 2 for each in x)
    return a + 2 * b + sum((j + 3) * each for j, each in enumerate(others))


@pytest.mark.parametrize(
    ("fun", "takes_many"),
    [
        (lambda x: x**2 @ np.arange(1, x.shape[-1] + 1), True),  # both, and they mean the same
        (lambda x: (x[:, :] ** 2 * np.arange(1, x.shape[1] + 1)).sum(axis=1), True),
        (lambda x: (x**2 * np.arange(1, x.shape[1] + 1)).sum(axis=1, keepdims=True), True),  # (n, 1)
        (one_by_one, True),  # a list
        (lambda x: (x**2 * np.arange(1, len(x) + 1)).sum(), False),
        (lambda x: x @ A[: len(x), : len(x)] @ x, False),  # of n = d points it would take a matrix
        (lambda x: sum((j + 1) * x[j] ** 2 for j in range(len(x))), False),  # of n points it gives d values
        (lambda x: np.array([(x**2 * np.arange(1, len(x) + 1)).sum()]), False),  # its value in an array
        (unpacked, False),
    ],
)
@pytest.mark.parametrize("d", [2, 3, 4])
def test_one_call_finds_out_whether_a_function_takes_one_point_or_many(fun, takes_many, d):
    for n in (1, 2, 3, d, 5):
        points = np.random.default_rng(n).random((n, d))
        problem = FunctionProblem(fun, [0.0] * d, [1.0] * d)
        assert problem.evaluate(points) == pytest.approx(value(points))
        assert problem.evaluate(points).shape == (n,)
        assert problem._takes_many(points) == takes_many


def test_the_call_that_finds_out_is_made_once_and_has_points_of_the_box_that_are_no_square():
    shapes, points = [], np.full((2, 2), 0.25)
    problem = FunctionProblem(lambda x: shapes.append(x.shape) or x.sum(axis=1), [0.0] * 2, [1.0] * 2)
    assert shapes == []  # nothing is evaluated that nobody asked for
    problem.evaluate(points)
    problem.evaluate(points)
    assert shapes == [(3, 2), (2, 2), (2, 2)]


@pytest.mark.parametrize(
    ("lower", "upper", "sentence"),
    [
        ([1.0], [1.0], "every lower bound must be finite and below its upper bound"),
        ([0.0], [np.inf], "every lower bound must be finite"),
        ([1.0], [2.0, 3.0], "must be vectors of one length; give one value for each variable"),
        ([[1.0]], [[2.0]], "must be vectors of one length"),
    ],
)
def test_bounds_are_checked(lower, upper, sentence):
    with pytest.raises(BenchError) as caught:
        plane(lower, upper, name="mine")
    assert str(caught.value).startswith("problem 'mine': ")
    assert sentence in str(caught.value)


def test_a_problem_that_lacks_attributes_is_told_which():
    class Nameless(Problem):
        lower, upper = np.zeros(2), np.ones(2)

        def evaluate(self, x):
            return x.sum(axis=1)

    with pytest.raises(BenchError, match="the problem Nameless has no name and no variables"):
        with_own_box(Nameless())
