"""bipop-cma-es restarts in the regime that has spent less, until the budget ends."""

import math

import numpy as np
import pytest

from bench import FunctionProblem, solve
from optimizers.bipop_cma_es import BIPOPCMAES, NearestPoint, Run, restarts
from optimizers.cma_es import CMAES
from validation.archive import FACTOR, archived, measured

D = 5


def rastrigin(x):
    y = x - np.linspace(-2, 2.5, D)
    return (y**2 - 10 * np.cos(2 * np.pi * y) + 10).sum(axis=1)


def problem(function=rastrigin, seen=None):
    def watched(x):
        if seen is not None:
            seen.append(x.copy())
        return function(x)

    return FunctionProblem(watched, [-5.12] * D, [5.12] * D, vectorized=True)


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
    assert len(set(sizes[~doubled])) > 3
    np.testing.assert_allclose(steps[doubled], 1, atol=0.25)
    assert np.median(steps[~doubled]) == pytest.approx(0.1, rel=0.5)  # 10^(-2U)


@pytest.mark.slow
def test_rastrigin_is_solved_where_a_single_run_fails():
    solved = {
        optimizer: sum(solve(problem(), optimizer, budget=45_000, seed=seed).fun < 1e-8 for seed in range(8))
        for optimizer in (BIPOPCMAES(), CMAES())
    }
    assert solved[BIPOPCMAES()] >= 4
    assert solved[CMAES()] <= 1


def run(d=2, agents=6, mean=0.0, sigma=0.2):
    """A run in [-5, 5]^d; its first points have been drawn."""
    begun = Run(NearestPoint(np.full(d, -5.0), np.full(d, 5.0)), np.full(d, mean), sigma, agents,
                np.random.default_rng(5))  # fmt: skip
    begun.ask()
    return begun


def told(begun, values, generations):
    """The stops after each generation; ``values`` returns the values of generation k, from 1."""
    stops = []
    for k in range(1, generations + 1):
        begun.ask()
        begun.tell(np.asarray(values(k), dtype=float))
        stops.append(begun.stops)
    return stops


def test_weights_and_rates_are_the_tutorial_s_without_negative_weights():
    rates = run().parameters(5, 8)
    raw = np.log(4.5) - np.log([1, 2, 3, 4])
    np.testing.assert_allclose(rates.weights, [*raw / raw.sum(), 0, 0, 0, 0])
    mueff = raw.sum() ** 2 / (raw**2).sum()
    assert rates.cs == pytest.approx((mueff + 2) / (5 + mueff + 5))
    assert rates.damps == pytest.approx(1 + rates.cs)  # mueff < d + 2
    large = run().parameters(5, 256)
    assert large.cs > 0.8  # pycma has 0.5 at most
    assert large.damps == pytest.approx(1 + 2 * (math.sqrt((large.mueff - 1) / 6) - 1) + large.cs)


def test_points_outside_are_evaluated_at_the_nearest_point_of_the_box_and_penalised():
    begun = run()
    begun._points = np.array([[0, 0], [6, 0], [0, -5.5], [-7, 6], [5, 5], [1, 1]], dtype=float)
    np.testing.assert_array_equal(begun.box(begun.points)[[1, 2, 3]], [[5, 0], [0, -5], [-5, 5]])
    f = np.array([10.0, 20, 30, 40, 50, 60])  # the quartiles are 20 and 50
    np.testing.assert_allclose(begun.penalty(f), 30 * np.array([0, 1, 0.25, 5, 0, 0]))
    np.testing.assert_allclose(begun.penalty(1000 * f), 1000 * begun.penalty(f))
    assert not begun.penalty(np.full(6, np.inf)).any()
    assert np.isfinite(begun.penalty(np.array([1.0, 2, np.inf, np.inf, 3, 4]))).all()


def test_a_run_stops_when_the_bests_of_the_last_generations_lie_within_1e_12():
    window = 10 + 10  # 10 + ceil(30 d / lambda)
    stops = told(run(), lambda k: [1.0, 2, 3, 4, 5, 6 + k], window + 1)
    assert stops == [set()] * (window - 1) + [{"tolhistfun"}] * 2
    assert not any(told(run(), lambda k: [1 - 1e-13 * (20 * k), 2, 3, 4, 5, 6], 60))


def test_a_run_stops_when_best_and_kth_best_tie_in_a_third_of_the_generations():
    tied, free = [1, 1, 1, 4, 5, 6], [1, 2, 3, 4, 5, 6]  # k = 1 + ceil(0.1 + 6 / 4) = 3

    def values(k, every):
        return np.array(tied if k % every == 0 else free) - k

    stops = told(run(), lambda k: values(k, 3), 36)
    assert stops == [set()] * 35 + [{"equalfunvals"}]  # 10 + d of 3 (10 + d)
    assert not any(told(run(), lambda k: values(k, 4), 80))
    nearly = np.array([1, 1, 3, 4, 5, 6])
    assert not any(told(run(), lambda k: nearly - k, 80))


def test_a_run_stops_when_medians_of_bests_and_of_medians_no_longer_fall():
    def level(k):
        return np.array([k % 3 / 3, 2, 3, 4, 5, 6])

    assert told(run(), level, 130) == [set()] * 129 + [{"stagnation"}]  # 120 + 30 d / lambda = 130
    assert not any(told(run(), lambda k: level(k) - 0.01 * k, 200))


def test_a_run_stops_when_every_step_is_below_its_limit_and_not_because_the_steps_grew():
    begun = run()
    begun.tolx = 3.0
    assert told(begun, lambda k: np.arange(6) - k, 1) == [{"tolx"}]
    begun = run(sigma=1e-6)
    told(begun, lambda k: np.arange(6) - k, 1)
    begun.sigma *= 2000
    assert not told(begun, lambda k: np.arange(6) - k, 1)[0]  # pycma stops beyond 1000


@pytest.mark.slow
@pytest.mark.parametrize("function", [1, 9, 13, 15, 17])
def test_expected_running_times_are_those_of_bbob_2009(published, function):
    pytest.importorskip("cocoex", reason="bbob needs the extra suites")
    path = published / "bbob2009-bipop-cma-es-odd-functions.json"
    if not path.is_file():
        pytest.skip(f"no archived runs at {path}")
    theirs, longest = archived(path)[function, 5]
    ours = measured(BIPOPCMAES(), function, 5, 4 * longest)
    assert sum(ours.reached) == len(ours.reached)
    assert 1 / FACTOR <= ours.ert / theirs.ert <= FACTOR
