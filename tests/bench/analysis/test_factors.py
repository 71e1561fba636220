"""Main effects and interactions of sweeps, against other definitions of the same numbers."""

from itertools import product

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binomtest, kruskal, rankdata
from scipy.stats import permutation_test as permuted
from statsmodels.formula.api import ols
from statsmodels.stats.anova import anova_lm

from bench.analysis import a12
from bench.analysis.factors import (
    HIGHER,
    TRIALS,
    chances,
    contributions,
    decomposed,
    level_tests,
    mean_shares,
    permutation_test,
)
from bench.study.sweep import Sweep

FACTORS = {"a": ("1", "2", "3"), "b": ("x", "y")}


def sweep_of(factors=FACTORS):
    return Sweep("o", factors, {levels: f"o{levels}" for levels in product(*factors.values())})


@pytest.fixture
def made(frame_of):
    """Return a function that makes the frame of a sweep from a function of (problem, levels, rng)."""

    def make(value, problems=4, trials=6, factors=FACTORS):
        rng = np.random.default_rng(3)
        return frame_of(
            {
                (f"p{place}", f"o{levels}"): [value(place, levels, rng) for _ in range(trials)]
                for place in range(problems)
                for levels in product(*factors.values())
            }
        )

    return make


def test_a_chance_is_the_mean_a12_against_every_sample():
    rng = np.random.default_rng(0)
    samples = [rng.integers(0, 6, size).astype(float) for size in (3, 8, 5)]
    samples[1][0] = np.inf
    found = chances(samples)
    for own, values in zip(samples, found, strict=True):
        expected = [np.mean([a12(np.array([value]), other) for other in samples]) for value in own]
        np.testing.assert_allclose(values, expected, atol=1e-12)


def test_the_parts_of_a_function_add_up_and_are_orthogonal():
    grid = np.random.default_rng(1).normal(size=(3, 2, 4))
    parts = decomposed(grid)
    assert len(parts) == 8
    np.testing.assert_allclose(sum(np.broadcast_to(part, grid.shape) for part in parts.values()), grid)
    for axes, part in parts.items():
        for axis in axes:
            np.testing.assert_allclose(part.sum(axis=axis), 0, atol=1e-12)
    assert sum((part**2).mean() for part in parts.values()) == pytest.approx((grid**2).mean())


def test_the_shares_are_those_of_an_analysis_of_variance(made):
    frame = made(lambda place, levels, rng: int(levels[0]) + 0.5 * (levels[1] == "x") * int(levels[0]) + rng.normal())
    own = frame[frame["problem"] == "p0"]
    samples = {label: each["fun"].to_numpy() for label, each in own.groupby("optimizer", sort=False)}
    table = pd.concat(
        pd.DataFrame({"y": found, "a": label[3], "b": label[8]})
        for label, found in zip(samples, chances(list(samples.values())), strict=True)
    )
    anova = anova_lm(ols("y ~ C(a) * C(b)", table).fit())
    error, n = anova.loc["Residual", "mean_sq"], len(table)
    variances = ((anova["sum_sq"] - anova["df"] * error) / n).clip(lower=0)
    variances["Residual"] = error
    expected = (variances / variances.sum()).tolist()
    effects = contributions(frame, sweep_of()).effects
    found = effects[effects["problem"] == "p0"].set_index("component")["share"]
    np.testing.assert_allclose(found[["a", "b", "a × b", TRIALS]], expected, atol=1e-12)


def test_each_kind_of_effect_is_found_where_it_is(made):
    factors = {"a": ("1", "2"), "b": ("1", "2"), "c": ("1", "2")}
    kinds = {
        "a": lambda levels: int(levels[0]),
        "a × b": lambda levels: int(levels[0]) ^ int(levels[1]),
        HIGHER: lambda levels: int(levels[0]) ^ int(levels[1]) ^ int(levels[2]),
        TRIALS: lambda _: 0,
    }
    for kind, value in kinds.items():
        frame = made(lambda _, levels, rng, value=value: 5 * value(levels) + rng.normal(), factors=factors)
        shares = mean_shares(contributions(frame, sweep_of(factors)).effects)
        assert shares.sum() == pytest.approx(1)
        assert shares.idxmax() == kind
        assert shares[kind] > 0.6


def test_one_block_of_ranks_is_the_permutation_test_of_kruskal_and_wallis():
    rng = np.random.default_rng(2)
    samples = [rng.integers(0, 9, size).astype(float) for size in (4, 3, 5)]
    expected = permuted(
        samples, lambda *them: kruskal(*them).statistic, permutation_type="independent", alternative="greater",
        n_resamples=2_000, rng=np.random.default_rng(1),
    ).pvalue  # fmt: skip
    ranks = np.split(rankdata(np.concatenate(samples)), [4, 7])
    assert permutation_test([ranks]) == pytest.approx(expected, abs=0.04)
    assert permutation_test([[np.zeros(3), np.zeros(4)]] * 2) == 1.0


def test_two_values_of_one_trial_a_block_have_the_p_of_all_exchanges():
    """Of the 2^8 ways to exchange the values within blocks, two are as far apart as one that always wins."""
    assert permutation_test([[np.array([1.0]), np.array([9.0])]] * 8) == pytest.approx(2 / 2**8, abs=0.004)


def test_blocks_that_differ_in_level_or_direction_hide_nothing():
    rng = np.random.default_rng(5)
    blocks = [
        [level + rng.normal(size=10), level + step + rng.normal(size=10)] for level, step in ((0, 2), (50, -2), (90, 2))
    ]
    pooled = [np.concatenate(each) for each in zip(*blocks, strict=True)]
    assert permutation_test(blocks) < 1e-3 < kruskal(*pooled).pvalue


def test_a_parameter_matters_where_its_best_value_depends_on_another_one(made):
    factors = {"a": ("1", "2"), "b": ("x", "y")}
    crossed = made(lambda _, own, rng: 3 * ((own[0] == "1") == (own[1] == "x")) + rng.normal(), factors=factors)
    tests = contributions(crossed, sweep_of(factors)).tests.set_index("factor")
    assert tests["p_here"].max() < 0.001
    assert tests.at["b", "worse"] == []
    assert tests["p_holm"].min() > 0.05


def test_values_shown_to_be_worse_are_those_of_a_parameter_that_matters(made):
    frame = made(lambda _, levels, rng: 2 * (levels[0] == "3") + rng.normal())
    tests = contributions(frame, sweep_of()).tests.set_index("factor")
    assert tests.at["a", "worse"] == ["3"]
    assert tests.at["b", "worse"] == []
    assert tests.at["a", "p_here"] < 0.001 < 0.05 < tests.at["b", "p_here"] <= tests.at["b", "p_holm"]


def test_values_are_tested_across_problems(made):
    frame = made(lambda _, levels, rng: 3 * (levels[1] == "x") + rng.normal(), problems=8)
    found = contributions(frame, sweep_of())
    tests = level_tests(found.levels).set_index("factor")
    assert tests.loc["b", "best"] == "y"
    assert tests.loc["b", "first"] == tests.loc["b", "problems"] == 8
    table = found.levels[found.levels["factor"] == "b"].pivot(index="problem", columns="level", values="chance")
    assert tests.loc["b", "p"] == pytest.approx(binomtest(int((table["x"] > table["y"]).sum()), 8).pvalue)
    assert tests.loc["b", "p_holm"] <= 0.05 < tests.loc["a", "p_holm"]


def test_a_parameter_without_effect_has_no_share_in_expectation(made):
    frame = made(lambda _, levels, rng: rng.normal(), problems=60)
    assert mean_shares(contributions(frame, sweep_of()).effects)[["a", "b", "a × b"]].max() < 0.02


def test_failed_trials_are_worst_and_equal_ones_tie(made):
    frame = made(lambda _, levels, rng: None if levels[1] == "x" else 1.0)
    found = contributions(frame, sweep_of())
    assert mean_shares(found.effects)["b"] == pytest.approx(1)
    assert level_tests(found.levels).set_index("factor")["note"].to_dict() == {"a": "identical", "b": "untestable"}
    alike = contributions(made(lambda *_: 7.0), sweep_of())
    assert alike.effects["share"].isna().all()
    assert (level_tests(alike.levels)["best"] == "").all()


def test_few_trials_and_missing_cells(made):
    frame = made(lambda _, levels, rng: rng.normal(), trials=1)
    assert contributions(frame, sweep_of()).effects["share"].isna().all()
    frame = made(lambda _, levels, rng: rng.normal())
    lacking = frame[~((frame["problem"] == "p1") & (frame["optimizer"] == "o('1', 'x')"))]
    found = contributions(lacking[lacking["problem"] != "p2"], sweep_of())
    assert found.left_out == ["p1"]
    assert list(found.levels["problem"].unique()) == ["p0", "p3"]


def test_a_parameter_with_one_value_is_none(made):
    factors = {"a": ("1", "2"), "b": ("x",)}
    found = contributions(made(lambda _, levels, rng: rng.normal(), factors=factors), sweep_of(factors))
    assert list(found.levels["factor"].unique()) == ["a"]
