"""scipy's global optimizers run as scipy runs them, within the budget, from the seed alone, and in silence."""

import numpy as np
import pytest
from scipy import optimize
from threadpoolctl import threadpool_limits

from bench import solve
from bench.contract.seeds import streams
from optimizers.scipy import MEMBERS, scipy
from tests.optimizers.observed import BEST, LOWER, UPPER, Recorded


def waves(x):
    y = 10 * (x - BEST[: x.shape[1]]) / (UPPER - LOWER)[: x.shape[1]]
    return (y**2 - 10 * np.cos(2 * np.pi * y) + 10).sum(axis=1)


def run(name, *, on=waves, d=3, budget=400, seed=1, **options):
    problem = Recorded(on, d)
    result = solve(problem, scipy.load(f"scipy:{name}", **options), budget=budget, seed=seed)
    return result, np.concatenate(problem.points), problem.sizes


def test_differential_evolution_is_scipy_s():
    ours = solve(Recorded(waves), MEMBERS["differential_evolution"](agents=20, tol=0.0), budget=700, seed=4)
    start, search = streams(4)
    values = []
    theirs = {
        "bounds": list(zip(LOWER, UPPER, strict=True)),
        "init": LOWER + (UPPER - LOWER) * start.random((20, 3)),
        "maxiter": 34,
        "tol": 0.0,
        "polish": False,
        "rng": search,
    }
    optimize.differential_evolution(lambda x: values.append(waves(x[np.newaxis])[0]) or values[-1], **theirs)
    assert (ours.nfev, len(values)) == (700, 700)
    assert ours.fun == min(values)


def test_dual_annealing_is_scipy_s():
    ours = solve(Recorded(waves), MEMBERS["dual_annealing"](), budget=900, seed=4)
    start, search = streams(4)
    values = []
    x0 = LOWER + (UPPER - LOWER) * start.random(3)
    with threadpool_limits(limits=1):
        optimize.dual_annealing(
            lambda x: values.append(waves(x[np.newaxis])[0]) or values[-1],
            list(zip(LOWER, UPPER, strict=True)),
            x0=x0,
            maxfun=900,
            rng=search,
        )
    assert ours.fun == min(values[:900])


def test_direct_is_scipy_s():
    values = []
    optimize.direct(
        lambda x: values.append(waves(np.atleast_2d(x))[0]) or values[-1], optimize.Bounds(LOWER, UPPER), maxfun=10_000
    )
    ours, points, _ = run("direct", budget=10_000)
    np.testing.assert_allclose(waves(points), values[: len(points)], rtol=1e-12)
    assert ours.nfev == len(values)


@pytest.mark.sampled(6)
@pytest.mark.parametrize(
    ("name", "option"),
    [
        *(
            ("differential_evolution", option)
            for option in [
                {"agents": 20}, {"strategy": "rand1exp"}, {"mutation": 0.1}, {"mutation_to": None},
                {"recombination": 0.1}, {"updating": "deferred"}, {"tol": 1.0}, {"atol": 1e3},
                {"handling": "box"},
            ]
        ),
        *(
            ("dual_annealing", option)
            for option in [
                {"initial_temp": 1.0}, {"restart_temp_ratio": 0.9}, {"visit": 2.0}, {"accept": -500.0},
                {"no_local_search": True}, {"handling": "box"},
            ]
        ),
        ("direct", {"eps": 0.1}), ("direct", {"locally_biased": False}),
        ("direct", {"vol_tol": 0.01}), ("direct", {"len_tol": 0.2}),
        *(
            ("basinhopping", option)
            for option in [
                {"T": 1e3}, {"stepsize": 0.5}, {"interval": 2}, {"target_accept_rate": 0.1, "interval": 4},
                {"stepwise_factor": 0.1, "interval": 2}, {"niter_success": 1},
            ]
        ),
    ],
)  # fmt: skip
def test_every_parameter_changes_the_run(name, option):
    class Rounded(Recorded):
        def repair(self, x):
            return np.clip(np.round(x, 2), self.lower, self.upper)

    base = {"differential_evolution": {"agents": 15}, "basinhopping": {"interval": 4}}.get(name, {})
    traces = []
    for options in (base, base | option):
        problem = Rounded(waves)
        solve(problem, scipy.load(f"scipy:{name}", **options), budget=800, seed=1)
        traces.append(np.concatenate(problem.points))
    assert not np.array_equal(*traces)
