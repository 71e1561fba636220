"""The contract of a problem, and a user's own function as a problem."""

import pickle

import numpy as np
import pytest

from bench import BenchError, FunctionProblem


def plane(lower=(-1, 0), upper=(1, 4), **options):
    return FunctionProblem(lambda x: x.sum(axis=1), lower, upper, **options)


def test_a_function_of_one_point_can_be_a_problem():
    problem = FunctionProblem(lambda x: float(x[0] ** 2), [-1], [1], vectorized=False)
    assert problem.evaluate(np.array([[0.5], [1.0]])).tolist() == [0.25, 1.0]


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


def test_variables_have_different_names():
    assert plane().variables == ("x1", "x2")
    assert plane(variables="ab").variables == ("a", "b")
    for names in ("a", "aa", "abc"):
        with pytest.raises(BenchError, match="give 2 different variable names"):
            plane(variables=names)


def test_points_are_repaired_to_the_box_and_described_by_nothing():
    problem = plane()
    assert problem.repair(np.array([[-3.0, 2.0], [0.5, 9.0]])).tolist() == [[-1.0, 2.0], [0.5, 4.0]]
    assert problem.dimension == 2
    assert problem.describe(np.zeros(2)) == problem.expected == {}
    assert problem.fingerprint() == ""
    assert problem.optimum is None


def test_the_bounds_are_copies():
    lower = np.zeros(2)
    problem = plane(lower)
    lower[:] = 1.0
    assert problem.lower.tolist() == [0.0, 0.0]


def test_a_problem_may_say_what_kind_it_is():
    assert plane().features == {}
    assert pickle.loads(pickle.dumps(FunctionProblem(np.sum, [0], [1]))).features == {}
    assert plane(features={"suite": "planes", "instance": 2}).features == {"suite": "planes", "instance": 2}
