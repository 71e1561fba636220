"""bipop-cma-es restarts in the regime that has spent less, until the budget ends."""

import math
from itertools import groupby

import numpy as np
import pytest

from bench import FunctionProblem, solve
from optimizers.bipop_cma_es import BIPOPCMAES, restarts
from optimizers.cma_es import CMAES

D = 5


def rastrigin(x):
    y = x - np.linspace(-2, 2.5, D)
    return (y**2 - 10 * np.cos(2 * np.pi * y) + 10).sum(axis=1)


def problem(function=rastrigin, seen=None):
    def watched(x):
        if seen is not None:
            seen.append(x.copy())
        return function(x)

    return FunctionProblem(watched, [-5.12] * D, [5.12] * D)


def test_the_regime_that_has_spent_less_is_next_and_large_populations_double():
    plan = restarts(10, np.random.default_rng(0))
    assert next(plan) == (10, 1.0, math.inf)
    assert plan.send(500) == (20, 1.0, math.inf)  # the first run counts to the small ones
    assert plan.send(600)[2] == 300  # 500 small, 600 large; half of the last large run
    assert plan.send(50)[2] == 300  # 550 against 600: small again
    assert plan.send(50) == (40, 1.0, math.inf)  # a tie goes to the large ones
    assert plan.send(4000)[2] == 2000


def test_small_populations_and_steps_follow_the_paper():
    plan = restarts(10, np.random.default_rng(1))
    next(plan)
    assert [plan.send(0)[0] for _ in range(4)] == [20, 40, 80, 160]
    plan.send(10**9)
    drawn = np.array([plan.send(0)[:2] for _ in range(4000)])
    assert drawn[:, 0].min() == 10
    assert drawn[:, 0].max() <= 80
    # floor(10 * 8^(U^2)) is at most 20 for U^2 <= 1/3, or just below 21
    below = math.sqrt(math.log(2.1) / math.log(8))
    assert (drawn[:, 0] <= 20).mean() == pytest.approx(below, abs=0.03)
    np.testing.assert_allclose(np.quantile(np.log10(drawn[:, 1]), [0.0, 0.25, 0.5, 1.0]), [-2, -1.5, -1, 0], atol=0.07)


def test_a_run_makes_the_planned_restarts_and_spends_the_whole_budget():
    seen = []
    result = solve(problem(seen=seen), BIPOPCMAES(agents=8), budget=12_000, seed=2)
    assert (result.nfev, result.stop) == (12_000, "budget")
    populations = [size for size, _ in groupby(len(batch) for batch in seen)]
    assert populations[:2] == [8, 16]
    large = [size for size in populations if size in (16, 32, 64, 128)]
    assert sorted(set(large)) == large  # each is there once, doubled
    assert len(set(populations)) > len(large) + 1  # and others in between


def test_restarts_begin_at_points_of_their_own_with_the_step_of_their_regime():
    seen = []
    flat = problem(lambda x: np.zeros(len(x)), seen)  # every run ends after its first generation
    solve(flat, BIPOPCMAES(agents=6, start="midpoint", sigma=0.01), budget=3000, seed=3)
    starts = np.array([batch.mean(axis=0) for batch in seen])
    assert np.abs(starts[0]).max() < 0.2
    assert np.abs(starts[1:]).max(axis=1).min() > 0.2
    assert len(np.unique(starts.round(1), axis=0)) == len(starts)
    steps = np.array([batch.std(axis=0).mean() for batch in seen]) / (0.01 * 10.24)
    sizes = np.array([len(batch) for batch in seen])
    doubled = sizes == np.maximum.accumulate(sizes)  # the small populations are at most half of the last large one
    np.testing.assert_allclose(steps[doubled], 1, atol=0.25)
    assert np.median(steps[~doubled]) == pytest.approx(0.1, rel=0.5)  # 10^(-2U)


def test_rastrigin_is_solved_where_a_single_run_fails():
    solved = {
        optimizer: sum(solve(problem(), optimizer, budget=45_000, seed=seed).fun < 1e-8 for seed in range(8))
        for optimizer in (BIPOPCMAES(), CMAES())
    }
    assert solved[BIPOPCMAES()] >= 4
    assert solved[CMAES()] <= 1


def test_a_seed_repeats_a_run():
    first, again, other = (solve(problem(), BIPOPCMAES(), budget=4000, seed=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.trace.values, again.trace.values)
    assert first.fun != other.fun
