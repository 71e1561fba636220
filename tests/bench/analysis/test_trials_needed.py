"""The number of trials that would separate a pair: against the formula, against repeated studies, and odd samples."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import mannwhitneyu, norm

from bench.analysis.direction import a12, effects, p_values
from bench.analysis.pairwise import pairwise_tests
from bench.analysis.trials_needed import LARGEST, MOST_PAIRS, noether, trials_needed

NOBODY = pd.DataFrame({"problem": [], "optimizer": [], "rank": []})  # few pairs need no leader


def needed_of(frame_of, cells, **options):
    frame = frame_of(cells)
    return trials_needed(frame, pairwise_tests(frame), NOBODY, **options)


def test_noether_s_formula_by_hand_and_by_its_own_test():
    # z(0.975) + z(0.8) = 1.960 + 0.842: 7.849 / (6 x 0.2^2) = 32.7
    assert noether(0.7, 0.05, 0.8) == pytest.approx(32.70, abs=0.01)
    assert noether(0.3, 0.05, 0.8) == pytest.approx(noether(0.7, 0.05, 0.8))
    assert noether(0.5, 0.05, 0.8) == np.inf
    rng = np.random.default_rng(1)
    shift = norm.ppf(0.7) * np.sqrt(2)  # A12 of 0.7
    x, y = rng.normal(0, 1, (1_000, 33)), rng.normal(shift, 1, (1_000, 33))
    assert np.mean(mannwhitneyu(x, y, axis=1).pvalue <= 0.05) == pytest.approx(0.8, abs=0.04)


def separated(draw, n, level, studies=400):
    """The share of studies of n trials in which the test separates two optimizers."""
    these, others = zip(*(draw(np.random.default_rng(seed), n) for seed in range(studies)), strict=True)
    return np.mean(p_values(effects(np.array(these), np.array(others))) <= level)


def shifted(rng, n):
    return rng.normal(0, 1, n), rng.normal(0.75, 1, n)


def two_basins(rng, n):
    # one ends in the good basin in 70 % of trials, the other in 40 %
    return (rng.normal(0, 0.1, n) + 5 * (rng.random(n) > share) for share in (0.7, 0.4))


@pytest.mark.parametrize("draw", [shifted, two_basins])
def test_as_many_trials_as_are_needed_separate_four_studies_of_five(frame_of, draw):
    # samples so large that they are the truth, with a level at which even they do not separate the pair
    x, y = draw(np.random.default_rng(7), 400)
    frame = frame_of({("p", "a"): x[:20], ("p", "b"): y[:20]})
    pairs = pairwise_tests(frame).assign(lower="", n_first=4, n_second=4)
    large = frame_of({("p", "a"): x, ("p", "b"): y})
    row = trials_needed(large, pairs.assign(a12=a12(x, y)), NOBODY).iloc[0]
    assert row["method"] == "simulation"
    made = separated(draw, int(row["needed"]), 0.05)
    assert made == pytest.approx(0.8, abs=0.12)  # standard error 0.033, and that of x and y
    assert separated(draw, int(0.6 * row["needed"]), 0.05) < made - 0.1


def test_simulation_and_formula_agree_where_the_formula_holds(frame_of):
    x, y = (norm.ppf((np.arange(60) + 0.5) / 60) + shift for shift in (0.0, 0.35))
    row = needed_of(frame_of, {("p", "a"): x, ("p", "b"): y}).iloc[0]
    formula = noether(row["a12"], 0.05, 0.8)
    assert 60 < formula < 150
    assert 0.8 * formula < row["needed"] < 1.25 * formula


def test_the_range_is_that_of_the_interval_of_a12(frame_of):
    rng = np.random.default_rng(2)
    row = needed_of(frame_of, {("p", "a"): rng.normal(0, 1, 30), ("p", "b"): rng.normal(0.15, 1, 30)}).iloc[0]
    assert row["a12_low"] < 0.5 < row["a12_high"]
    assert row["low"] < row["needed"] < LARGEST
    assert row["high"] == np.inf
    assert row["low"] == pytest.approx(row["needed"] * ((row["a12"] - 0.5) / (row["a12_high"] - 0.5)) ** 2, rel=0.05)


def test_a_pair_without_tendency_is_practically_not_separable(frame_of):
    x = np.arange(20.0)
    row = needed_of(frame_of, {("p", "a"): x, ("p", "b"): x + 0.5}).iloc[0]
    assert row["needed"] == np.inf
    spread = needed_of(frame_of, {("p", "a"): 30 * (x - 9.5), ("p", "b"): x - 9.6}).iloc[
        0
    ]  # significant, but no direction
    assert spread["needed"] == np.inf
    same = needed_of(
        frame_of, {("p", "a"): [1.0] * 9, ("p", "b"): [1.0] * 9, ("q", "a"): [None] * 9, ("q", "b"): [None] * 9}
    )
    assert same["needed"].tolist() == [np.inf, np.inf]


def test_few_trials(frame_of):
    apart = needed_of(frame_of, {("p", "a"): [1.0, 2, 3], ("p", "b"): [7.0, 8, 9]}).iloc[0]
    assert apart["needed"] == 6  # complete separation has p = 1/16 with five, and 1/32 with six
    single = needed_of(frame_of, {("p", "a"): [1.0], ("p", "b"): [2.0]}).iloc[0]
    assert np.isnan(single["needed"])
    nothing = needed_of(frame_of, {("p", "a"): [], ("p", "b"): [2.0, 3.0]})
    assert len(nothing) == 0 or np.isnan(nothing.iloc[0]["needed"])


def test_separated_pairs_are_left_out_and_lower_the_level_of_the_others_as_holm_does(frame_of):
    rng = np.random.default_rng(3)
    cells = {("p", name): rng.normal(shift, 1, 25) for name, shift in (("a", 0), ("b", 0.0), ("c", 9))}
    found = needed_of(frame_of, cells)
    assert found[["first", "second"]].to_numpy().tolist() == [["a", "b"]]
    assert found["level"].tolist() == [0.05]
    early = needed_of(frame_of, {key: values[:3] for key, values in cells.items()})
    assert early["level"].round(6).tolist() == [0.016667] * 3


def test_of_very_many_pairs_those_with_the_leader_by_the_formula(frame_of):
    rng = np.random.default_rng(3)
    number = 16
    assert number * (number - 1) / 2 > MOST_PAIRS
    frame = frame_of({("p", f"o{i}"): rng.normal(0, 1, 8) for i in range(number)})
    standing = pd.DataFrame({"problem": "p", "optimizer": ["o0", "o3", "o5"], "rank": [2.5, 1.0, 2.5]})
    found = trials_needed(frame, pairwise_tests(frame), standing)
    assert len(found) == number - 1
    assert set(found["method"]) == {"formula"}
    known = found[np.isfinite(found["needed"])]
    expected = np.maximum(noether(known["a12"], known["level"], 0.8), 9)
    assert known["needed"].tolist() == np.ceil(expected).tolist()


def test_ties_are_drawn_as_ties(frame_of):
    # half of the trials of both end at the optimum exactly; the others differ
    x = [0.0] * 15 + np.linspace(1, 2, 15).tolist()
    y = [0.0] * 11 + np.linspace(1.2, 2.2, 19).tolist()
    row = needed_of(frame_of, {("p", "a"): x, ("p", "b"): y}).iloc[0]
    assert 31 <= row["needed"] < 300
