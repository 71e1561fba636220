"""The design problems: published values, feasibility of the best designs, and that no feasible design is better."""

import pickle

import numpy as np
import pytest
from scipy.optimize import minimize

from bench import BenchError, load_problem
from bench.scoring import scored
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
CONSTRAINTS = {
    "cantilever-beam": 1, "gear-train": 0, "i-beam": 2, "pressure-vessel": 4, "speed-reducer": 11, "spring": 4,
    "three-bar-truss": 3, "tubular-column": 2, "welded-beam": 7,
}  # fmt: skip


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
def test_no_feasible_design_is_better(name):
    problem = load_problem(name)
    rng = np.random.default_rng(11)
    near = problem.optimum_point * (1 + 1e-3 * rng.standard_normal((50_000, problem.dimension)))
    x = problem.repair(np.concatenate([rng.uniform(problem.lower, problem.upper, (50_000, problem.dimension)), near]))
    found = problem.evaluate(x)[feasible(problem, x)]
    assert len(found) > 0
    assert found.min() >= problem.optimum * (1 - 1e-12)


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


def test_no_gear_train_is_better():
    problem = load_problem("engineering-gear-train")
    teeth = np.arange(12, 61)
    drivers = np.stack(np.meshgrid(teeth, teeth, indexing="ij"), axis=-1).reshape(-1, 2)
    drivers = drivers[drivers[:, 0] <= drivers[:, 1]]
    best = min(problem.evaluate(np.hstack([drivers, np.tile(pair, (len(drivers), 1))])).min() for pair in drivers)
    assert best == problem.optimum


@pytest.mark.parametrize("name", DESIGNS)
def test_values_and_violations_depend_on_the_point_alone(name):
    problem = load_problem(name)
    x = np.random.default_rng(3).uniform(problem.lower, problem.upper, (17, problem.dimension))
    for function in (problem.evaluate, problem.violations):
        whole = function(x)
        np.testing.assert_array_equal(np.concatenate([function(row[None]) for row in x]), whole)
        np.testing.assert_array_equal(function(np.asfortranarray(x)), whole)
        assert np.isfinite(whole).all()
    assert problem.violations(x).shape == (17, CONSTRAINTS[name.partition("-")[2]])
    again = pickle.loads(pickle.dumps(problem))
    np.testing.assert_array_equal(again.evaluate(x), problem.evaluate(x))


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


def test_rounding_is_no_repair_of_constraints():
    with pytest.raises(BenchError, match="'engineering-spring' has no rule that repairs violated constraints"):
        scored(load_problem("engineering-spring"), "repair")
    gears = load_problem("engineering-gear-train")
    assert scored(gears, "repair").handling == ""
    assert gears.integer.all()
    assert load_problem("engineering-speed-reducer").integer.tolist() == [False, False, True, *[False] * 4]
    assert load_problem("engineering-spring").integer is None


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
