"""bbob-constrained against COCO's own package."""

import numpy as np
import pytest

from bench import load_problem
from bench.trial.scoring import scored
from tests.problems.bbob.best import function_of, name

CASES = [
    *(("bbob-constrained", function, 5, 3) for function in range(1, 55)),
    *(("bbob-constrained", *rest) for rest in ((8, 2, 1), (54, 20, 15), (27, 40, 2))),
]


@pytest.mark.parametrize("case", CASES)
def test_values_constraints_and_optimum_are_those_of_coco(case, best):
    problem, function = load_problem(name(*case)), function_of(*case)
    x = np.random.default_rng(1).uniform(-5, 5, (20, case[2]))
    np.testing.assert_array_equal(problem.evaluate(x), [function(row) for row in x])
    np.testing.assert_array_equal(problem.violations(x), [function.constraint(row) for row in x])
    assert problem.features["constraints"] == problem.violations(x).shape[1]
    assert problem.optimum == pytest.approx(function(best[case]), rel=1e-14)
    assert (problem.violations(best[case][None]) <= 0).all()


@pytest.mark.sampled(4)
@pytest.mark.parametrize("function", range(1, 55, 4))
def test_no_feasible_point_beats_the_optimum(function):
    problem = scored(load_problem(name("bbob-constrained", function, 3, 1)), "death")
    rng = np.random.default_rng(4)
    start = function_of("bbob-constrained", function, 3, 1).initial_solution  # feasible
    x = problem.repair(start + rng.standard_normal((20_000, 3)) * 10.0 ** rng.uniform(-3, 0.5, (20_000, 1)))
    found = problem.evaluate(np.vstack([start, x]))
    assert np.isfinite(found[0])
    assert found.min() >= problem.optimum - 1e-12 * abs(problem.optimum)
