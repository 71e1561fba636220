"""A12 with its test and interval: against a literal formula and scipy, by hand, and as often wrong as they say."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom, brunnermunzel, fisher_exact, mannwhitneyu, norm

from bench.analysis.direction import LEAST_SHARE, UNTIED, a12, effects, intervals, least_p, p_values, wins

INF = float("inf")
SIZES = [(2, 2), (5, 5), (9, 4), (3, 11), (30, 30)]
MANY = 20_000  # pairs of samples of a rate

values = st.lists(st.integers(-9, 9) | st.just(INF), min_size=2, max_size=9)


def samples(n, m, kind="untied", number=40):
    rng = np.random.default_rng(n + 100 * m)
    if kind == "untied":
        return rng.normal(size=(number, n)), rng.normal(rng.uniform(-1, 1, (number, 1)), 2, (number, m))
    this, other = rng.integers(0, 5, (number, n)).astype(float), rng.integers(0, 6, (number, m)).astype(float)
    if kind == "failed":
        this[this == 4], other[other >= 4] = INF, INF
    return this, other


def effect_of(this, other):
    return effects(np.array([this], dtype=float), np.array([other], dtype=float))


def reference(this, other):
    """A12 and the ratio of its variance, from the placement of each value in the other sample."""
    won = wins(this, other)
    chance = won.mean()
    variance = won.mean(axis=1).var(ddof=1) / len(this) + won.mean(axis=0).var(ddof=1) / len(other)
    ratio = variance / (chance * (1 - chance)) if 0 < chance < 1 else 0.0
    # the variance of A12 where the values are dealt at random, as scipy's test of Mann and Whitney has it
    pooled = np.append(this, other)
    most = max(len(pooled) - UNTIED, 0)
    counts = np.unique(pooled, return_counts=True)[1]
    tied = min((counts**3 - counts).sum(), most**3 - most)
    dealt = len(pooled) + 1 - tied / (len(pooled) * (len(pooled) - 1))
    return chance, max(ratio, LEAST_SHARE * 4 * dealt / (12 * len(this) * len(other)))


def test_wins_by_hand():
    assert wins(np.array([1.0, INF]), np.array([1.0, 2.0, INF])).tolist() == [[0.5, 1, 1], [0, 0, 0.5]]


@pytest.mark.parametrize("kind", ["untied", "tied", "failed"])
@pytest.mark.parametrize(("n", "m"), SIZES)
def test_the_estimate_and_its_variance_are_those_of_the_placements(n, m, kind):
    these, others = samples(n, m, kind)
    found = effects(these, others)
    expected = np.array([reference(*pair) for pair in zip(these, others, strict=True)]).T
    np.testing.assert_allclose(found.a12, expected[0], rtol=1e-14)
    np.testing.assert_allclose(found.ratio, expected[1], rtol=1e-9)
    assert found.smaller == min(n, m)
    assert a12(these[0], others[0]) == pytest.approx(found.a12[0])
    assert found.a12[0] == pytest.approx(mannwhitneyu(others[0], these[0]).statistic / (n * m))


@pytest.mark.parametrize("kind", ["untied", "tied"])
@pytest.mark.parametrize(("n", "m"), [(9, 9), (12, 7), (30, 30)])
def test_the_statistic_is_brunner_and_munzel_s_with_the_variance_under_the_hypothesis(n, m, kind):
    these, others = samples(n, m, kind)
    found = effects(these, others)
    p = p_values(found)
    least = found.ratio > LEAST_SHARE * (n + m + 1) / (3 * n * m) * (1 + 1e-9)  # that of values without ties
    known = least & (p > least_p(found.smaller) * (1 + 1e-9))
    statistic = brunnermunzel(these[known], others[known], axis=1).statistic
    expected = np.abs(statistic) * np.sqrt(4 * found.a12[known] * (1 - found.a12[known]))
    assert known.sum() > 10
    np.testing.assert_allclose(norm.isf(p[known] / 2), expected, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("n", [2, 5, 30])
def test_complete_separation_by_hand(n):
    found = effect_of(np.arange(n), np.arange(n) + 100)
    assert (found.a12[0], found.ratio[0]) == (1.0, pytest.approx((2 * n + 1) / (4 * n**2)))
    assert p_values(found)[0] == least_p(n) == 2.0 ** (1 - n)
    assert found.inside[0] == (n + 1) / (n + 2)
    assert found.variance[0] > 0
    # all n disjoint pairs are won with a chance of at most a12^n, and that is 2.5 % at the lower end
    low, high = intervals(found)
    assert (low[0], high[0]) == pytest.approx((0.025 ** (1 / n), 1.0))
    mirrored = intervals(effect_of(np.arange(n) + 100, np.arange(n)))
    assert (mirrored[0][0], mirrored[1][0]) == pytest.approx((0.0, 1 - low[0]), abs=1e-12)


class TestProperties:
    @settings(max_examples=60)
    @given(values, values)
    def test_exchange_and_limits(self, this, other):
        found, mirrored = effect_of(this, other), effect_of(other, this)
        p, (low, high) = p_values(found)[0], (end[0] for end in intervals(found))
        assert found.a12[0] + mirrored.a12[0] == pytest.approx(1)
        assert p == pytest.approx(p_values(mirrored)[0])
        assert 2.0 ** (1 - min(len(this), len(other))) <= p <= 1
        assert -1e-15 <= low <= found.a12[0] <= high <= 1 + 1e-15
        assert [end[0] for end in intervals(mirrored)] == pytest.approx([1 - high, 1 - low], abs=1e-12)

    @settings(max_examples=30)
    @given(values, values, st.sampled_from([lambda v: 3 * v - 7, lambda v: v**3, lambda v: 1.5**v]))
    def test_only_the_order_of_values_counts(self, this, other, increasing):
        found, moved = (effect_of(f(np.array(this)), f(np.array(other))) for f in (np.asarray, increasing))
        assert (found.a12, found.ratio) == (moved.a12, moved.ratio)

    @pytest.mark.parametrize("alpha", [0.05, 0.005, 0.0001])
    @pytest.mark.parametrize(("n", "m"), SIZES)
    def test_the_interval_holds_a_half_where_the_test_does_not_reject(self, n, m, alpha):
        rng = np.random.default_rng(n + m)
        found = effects(rng.normal(size=(400, n)), rng.normal(rng.uniform(-3, 3, (400, 1)), 2, (400, m)))
        low, high = intervals(found, 1 - alpha)
        rejected = p_values(found) < alpha
        assert ((low <= 0.5) & (high >= 0.5)).tolist() == (~rejected).tolist()
        assert rejected.any() == (2.0 ** (1 - min(n, m)) < alpha)


class TestErrorRates:
    @pytest.mark.parametrize("n", [10, 30])
    @pytest.mark.parametrize("spread", [1, 2, 16, 256])
    def test_a_difference_in_spread_alone_is_found_no_more_often_than_the_level(self, spread, n):
        rng = np.random.default_rng(spread)
        p = p_values(effects(*(rng.standard_normal((2, MANY, n)) * [[[1]], [[spread]]])))
        for level in (0.05, 0.005, 0.001):
            assert np.mean(p <= level) <= level + 4 * np.sqrt(level * (1 - level) / MANY)
        assert np.mean(p <= 0.05) > 0.01  # it does reject

    @pytest.mark.parametrize("n", [15, 30, 51])
    def test_shares_of_successes_have_the_level_and_more_power_than_fisher_s_test(self, n):
        successes = np.arange(n + 1)
        these = (np.arange(n) >= successes[:, np.newaxis]).astype(float)
        one, other = np.indices((n + 1, n + 1)).reshape(2, -1)  # every outcome there is
        rejected = p_values(effects(these[one], these[other])) <= 0.05
        for share in (0.5, 0.7, 0.9, 0.98):
            chance = binom.pmf(successes, n, share)
            assert rejected @ (chance[one] * chance[other]) <= 0.06
        power = rejected @ ((successes[one] == n) * binom.pmf(other, n, 0.85))
        fisher = [fisher_exact([[n, 0], [lost, n - lost]]).pvalue <= 0.05 for lost in successes]
        assert power >= binom.pmf(successes, n, 0.85) @ fisher

    @pytest.mark.parametrize("n", [5, 10, 30])
    @pytest.mark.parametrize("true", [0.75, 0.95])
    def test_the_interval_covers_the_true_a12(self, true, n):
        rng = np.random.default_rng(n)
        these, others = rng.standard_normal((2, MANY, n))
        low, high = intervals(effects(these, others + np.sqrt(2) * norm.ppf(true)))
        assert np.mean((low <= true) & (true <= high)) >= 0.93 - 3 * np.sqrt(0.93 * 0.07 / MANY)
        assert np.mean(high - low) < {5: 0.75, 10: 0.5, 30: 0.3}[n]  # 0 to 1 would cover, too
