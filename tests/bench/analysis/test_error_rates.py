"""The levels that a design gives, the rates of false claims that they leave, and what they let a study find."""

import numpy as np
import pytest

from bench.analysis.direction import least_p
from bench.analysis.error_rates import (
    Levels,
    detectable_a12,
    detectable_across,
    levels,
    rates_of_equals,
    rates_of_spreads,
    trials_to_separate,
)

MOST = 0.05 + 4 * np.sqrt(0.05 * 0.95 / 1_000)  # of 1,000 studies
BOTH = Levels(0.025, 0.025, False)


@pytest.mark.parametrize(
    ("sizes", "pairs", "blocks", "expected"),
    [
        ([30] * 3, 10, 3, BOTH),  # all blocks of one sign have 10 / 4
        ([5] * 72, 3, 24, Levels(0.0, 0.05, True)),  # 216 / 16 on problems, 3 / 2^23 across blocks
        ([30] * 18, 10, 1, BOTH),
        ([30] * 18, 10, 18, Levels(0.025, 0.025, True)),
        ([30], 10, 1, Levels(0.05, 0.0, False)),
        ([6], 1, 1, Levels(0.05, 0.0, False)),  # 1/32: at the whole level alone
        ([5], 1, 1, Levels(0.0, 0.0, False)),  # 1/16
        ([1] * 24, 3, 24, Levels(0.0, 0.05, True)),
        ([1] * 3, 3, 3, Levels(0.0, 0.0, False)),
        ([13] * 18, 10, 18, Levels(0.0, 0.05, True)),  # 180 / 2^12 on problems: they cannot reject at half
        ([15] * 72, 10, 24, Levels(0.0, 0.05, True)),  # 720 / 2^14, likewise
        ([4, 4], 1, 2, Levels(0.0, 0.05, False)),  # 2/8 on problems, 1/128 for their mean
        ([], 1, 0, Levels(0.0, 0.0, False)),
    ],
)
def test_levels_by_hand(sizes, pairs, blocks, expected):
    assert levels(sizes, pairs, pairs * len(sizes), blocks) == expected


DESIGNS = [  # trials, optimizers, blocks
    (10, 3, ["p", "q", "r"]),
    (6, 2, ["p"]),
    (4, 3, [f"b{i // 2}" for i in range(20)]),
    (8, 4, ["one"] * 3),
]


@pytest.mark.parametrize(("trials", "optimizers", "blocks"), DESIGNS)
def test_false_claims_are_as_rare_as_the_level(trials, optimizers, blocks):
    pairs = optimizers * (optimizers - 1) // 2
    level = levels([trials] * len(blocks), pairs, pairs * len(blocks), len(set(blocks)))
    rng = np.random.default_rng(1)
    pools = [rng.normal(size=trials * optimizers) + 5 * (rng.random(trials * optimizers) < 0.5) for _ in blocks]
    for rates in (
        rates_of_equals(pools, optimizers, blocks, level),
        rates_of_spreads(trials, optimizers, blocks, level),
    ):
        assert rates.studies == 1_000
        assert max(rates.problems, rates.across) <= rates.any <= rates.problems + rates.across
        assert rates.any <= MOST
        assert rates.problems == 0 or level.problems > 0
        assert rates.across == 0 or level.across > 0


@pytest.mark.slow
def test_at_a_large_level_claims_are_common_and_seeds_repeat():
    pools, blocks = [np.arange(20.0)] * 4, list("pqrs")
    for further in (True, False):
        level = Levels(0.8, 0.8, further)
        found = rates_of_equals(pools, 2, blocks, level, seed=3)
        assert found == rates_of_equals(pools, 2, blocks, level, seed=3)
        assert found != rates_of_equals(pools, 2, blocks, level, seed=4)
        assert found.problems > 0.2
        assert found.across > 0.2
        assert rates_of_spreads(10, 2, blocks, level, 3) == rates_of_spreads(10, 2, blocks, level, 3)
        assert rates_of_spreads(10, 2, blocks, level, 3) != rates_of_spreads(10, 2, blocks, level, 4)


def test_values_that_are_all_tied_are_never_claimed_to_differ():
    rates = rates_of_equals([np.zeros(20)] * 7, 2, list("abcdefg"), Levels(0.025, 0.025))
    assert rates[1:] == (0.0, 0.0, 0.0)


def test_more_trials_detect_smaller_differences():
    found = [detectable_a12(trials, 0.05) for trials in (8, 16, 30, 100)]
    assert found == sorted(found, reverse=True)
    assert 0.5 < found[-1] < found[0] < 1
    assert detectable_a12(30, 0.05) < detectable_a12(30, 0.001)
    assert np.isnan(detectable_a12(1, 0.05))
    assert np.isnan(detectable_a12(5, 0.05))  # complete separation has 1/16


@pytest.mark.slow
@pytest.mark.parametrize("further", [True, False])
def test_more_trials_and_problems_detect_smaller_differences_across_problems(further):
    by_trials = [detectable_across(trials, 12, 0.05, further) for trials in (4, 10, 30)]
    assert by_trials == sorted(by_trials, reverse=True)
    assert 0.5 < by_trials[-1] < by_trials[0] < 1
    assert detectable_across(10, 24, 0.05, further) < by_trials[1]


def test_few_blocks_show_nothing_of_further_problems():
    assert np.isnan(detectable_across(30, 5, 0.05))
    assert detectable_across(30, 5, 0.05, further=False) < 0.7


@pytest.mark.filterwarnings("error")
def test_one_trial_a_cell_detects_a_difference_across_many_problems_alone():
    assert 0.5 < detectable_across(1, 24, 0.05) < 1
    assert np.isnan(detectable_across(1, 24, 0.05, further=False))


@pytest.mark.parametrize("tests", [0, 1, 30, 216])
@pytest.mark.parametrize("level", [0.05, 0.025])
def test_trials_to_separate_are_the_fewest(tests, level):
    trials, tests = trials_to_separate(tests, level), max(tests, 1)
    assert least_p(trials) * tests <= level < least_p(trials - 1) * tests
