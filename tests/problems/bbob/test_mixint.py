"""bbob-mixint against COCO's own package."""

import numpy as np
import pytest

from bench import load_problem
from tests.problems.bbob.best import function_of, name

CASES = [
    *(("bbob-mixint", function, 5, 3) for function in range(1, 25)),
    *(("bbob-mixint", *rest) for rest in ((8, 160, 1), (24, 40, 15), (15, 10, 70))),
]


@pytest.mark.parametrize("case", CASES)
def test_values_box_and_optimum_are_those_of_coco(case, best):
    problem, function = load_problem(name(*case)), function_of(*case)
    np.testing.assert_array_equal(problem.lower, function.lower_bounds)
    np.testing.assert_array_equal(problem.upper, function.upper_bounds)
    assert problem.integer.sum() == function.number_of_integer_variables == 4 * case[2] // 5
    x = np.random.default_rng(1).uniform(problem.lower, problem.upper, (20, case[2]))
    x = np.where(problem.integer, np.rint(x), x)
    np.testing.assert_array_equal(problem.evaluate(x), [function(row) for row in x])
    assert problem.optimum == pytest.approx(function(best[case]), rel=1e-12, abs=1e-12)
    assert problem.evaluate(x).min() >= problem.optimum
