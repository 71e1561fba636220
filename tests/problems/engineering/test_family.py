"""The design problems: published values, feasibility of the best designs, and that no feasible design is better."""

import pickle

import numpy as np
import pytest
from scipy.optimize import minimize

from bench import load_problem
from bench.trial.scoring import scored
from problems.engineering.family import DESIGNS

PUBLISHED = {  # the objective of the best-known design, as the papers in the docstrings print it
    "engineering-gear-train": 2.700857e-12,
    "engineering-i-beam": 0.0130741,
    "engineering-pressure-vessel": 6059.714335,
    "engineering-speed-reducer": 2994.471066,
    "engineering-spring": 0.0126652,
    "engineering-three-bar-truss": 263.895843,
    "engineering-tubular-column": 26.4995,
    "engineering-welded-beam": 1.724852,
    "engineering-cantilever-beam": 1.33996,
}


def feasible(problem, x):
    return (problem.violations(x) <= 0).all(axis=1)


@pytest.mark.parametrize("name", DESIGNS)
def test_the_best_design_is_in_the_box_feasible_and_of_the_published_value(name):
    problem = load_problem(name)
    best = problem.optimum_point[None]
    np.testing.assert_array_equal(problem.repair(best), best)
    assert feasible(problem, best).all()
    assert problem.optimum == problem.evaluate(best)[0] == pytest.approx(PUBLISHED[name], rel=5e-6)


@pytest.mark.parametrize("name", [name for name in DESIGNS if name != "engineering-gear-train"])
def test_sequential_quadratic_programming_ends_at_the_best_design(name):
    """From designs nearby, with the discrete variables held; values are scaled by those of the best design."""
    problem = load_problem(name)
    free = problem.steps == 0
    known = problem.optimum_point[free]
    box = list(zip(problem.lower[free] / known, problem.upper[free] / known, strict=True))
    rng = np.random.default_rng(2)
    scale = np.maximum(
        1, np.abs(problem.violations(rng.uniform(problem.lower, problem.upper, (99, problem.dimension))))
    )
    scale = np.median(scale, axis=0)

    def design(shares):
        x = problem.optimum_point.copy()
        x[free] *= shares
        return x[None]

    margin = {"type": "ineq", "fun": lambda shares: -problem.violations(design(shares))[0] / scale}
    ends = []
    for _ in range(5):
        found = minimize(
            lambda shares: problem.evaluate(design(shares))[0] / problem.optimum,
            1 + 0.02 * rng.standard_normal(free.sum()), bounds=box, constraints=margin, method="SLSQP",
            options={"ftol": 1e-14, "maxiter": 300},
        )  # fmt: skip
        if (margin["fun"](found.x) >= -1e-9).all():
            ends.append(found.fun)
    assert min(ends) == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize("handling", ["death", "penalty", "lexicographic"])
@pytest.mark.parametrize("name", [name for name in DESIGNS if name != "engineering-gear-train"])
def test_the_best_design_keeps_its_value_under_every_handling(name, handling):
    problem, rng = scored(load_problem(name), handling), np.random.default_rng(0)
    best = problem.problem.optimum_point[None]
    assert problem.assess(best, rng).shown[0] == problem.evaluate(best)[0] == problem.optimum
    assert problem.describe(best[0]) == {"violation": 0.0}
    x = np.random.default_rng(4).uniform(problem.lower, problem.upper, (99, problem.dimension))
    found = problem.assess(x, rng)
    assert np.isinf(found.values).any()
    assert (found.values >= problem.optimum).all()
    np.testing.assert_array_equal(np.concatenate([problem.assess(row[None], rng).shown for row in x]), found.shown)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(problem)).evaluate(x), found.values)


def test_a_discrete_variable_is_rounded():
    problem = load_problem("engineering-pressure-vessel")
    near = problem.optimum_point + np.array([0.03, -0.03, 0, 0])
    assert problem.evaluate(near[None])[0] == problem.optimum
    np.testing.assert_array_equal(problem.repair(near[None])[0], problem.optimum_point)
    assert load_problem("engineering-speed-reducer").rounded(np.full((1, 7), 17.4))[0].tolist()[:3] == [
        17.4,
        17.4,
        17.0,
    ]
