"""The levels that a design gives, the rates of false claims that they leave, and what they let a study find."""

import numpy as np
import pytest

from bench.analysis.across import across_problems
from bench.analysis.direction import least_p
from bench.analysis.error_rates import (
    Levels,
    claims,
    detectable_a12,
    detectable_across,
    levels,
    rates_of_equals,
    rates_of_spreads,
    trials_to_separate,
)
from bench.analysis.pairwise import pairwise_tests

MOST = 0.05 + 4 * np.sqrt(0.05 * 0.95 / 1_000)  # of 1,000 studies
BOTH = (0.01, 0.035, 0.005)


@pytest.mark.parametrize(
    ("sizes", "pairs", "expected"),
    [
        ([30] * 18, 10, BOTH),
        ([30] * 3, 10, BOTH),
        ([5] * 72, 3, (0.0, 0.045, 0.005)),  # 216 / 16 on problems
        ([15] * 72, 10, (0.0, 0.045, 0.005)),  # 720 / 2^14, above 0.01
        ([4, 4], 1, (0.0, 0.045, 0.005)),  # 2/8 on problems, 1/128 for their mean
        ([30], 10, (0.045, 0.045, 0.005)),  # one problem: both tests are the same
        ([6], 1, (0.045, 0.045, 0.005)),  # 1/32
        ([5], 1, (0.0, 0.0, 0.005)),  # 1/16
        ([1] * 24, 3, (0.0, 0.0, 0.005)),  # a single trial leaves no variance
        ([1] * 3, 3, (0.0, 0.0, 0.005)),
        ([2, 30], 10, (0.045, 0.0, 0.005)),  # the bound over both counts two trials of each
        ([], 1, (0.0, 0.0, 0.005)),
    ],
)
def test_levels_by_hand(sizes, pairs, expected):
    found = levels(sizes, pairs, pairs * len(sizes))
    assert found == pytest.approx(expected)
    assert found.course + (found.across if len(sizes) == 1 else found.across + found.problems) <= 0.05 + 1e-12


@pytest.mark.parametrize(("trials", "optimizers", "problems"), [(10, 3, 3), (7, 2, 1), (4, 3, 12), (8, 4, 3)])
def test_false_claims_are_as_rare_as_the_level(trials, optimizers, problems):
    pairs = optimizers * (optimizers - 1) // 2
    level = levels([trials] * problems, pairs, pairs * problems)
    rng = np.random.default_rng(1)
    pools = [
        [rng.normal(size=trials * optimizers) + 5 * (rng.random(trials * optimizers) < 0.5)] for _ in range(problems)
    ]
    for rates in (rates_of_equals(pools, optimizers, level), rates_of_spreads(trials, optimizers, problems, level)):
        assert rates.studies == 1_000
        assert max(rates.problems, rates.across) <= rates.any <= rates.problems + rates.across
        assert rates.any <= MOST
        assert rates.problems == 0 or level.problems > 0
        assert rates.across == 0 or level.across > 0


def test_claims_are_those_of_the_tests_of_a_report(frame_of):
    rng = np.random.default_rng(5)
    values = rng.normal(size=(4, 3, 8)) + np.array([0.0, 0.6, 1.5])[:, np.newaxis]  # problems, optimizers, trials
    level = Levels(0.05, 0.05)
    flags = claims([[of_problem[:, np.newaxis]] for of_problem in values], level)
    cells = {(f"p{i}", name): list(values[i, place]) for i in range(4) for place, name in enumerate("abc")}
    pairs = pairwise_tests(frame_of(cells), level.problems)
    tests = across_problems(pairs, alpha=level.across)
    shown = tests[tests["p"] <= level.across]["lower"].value_counts()
    expected = [pairs["significant"].any(), tests["significant"].any(), (shown == 2).any()]
    assert [bool(flag[0]) for flag in flags] == expected


def test_at_a_large_level_claims_are_common_and_seeds_repeat():
    pools, level = [[np.arange(20.0)]] * 4, Levels(0.8, 0.8)
    found = rates_of_equals(pools, 2, level, seed=3)
    assert found == rates_of_equals(pools, 2, level, seed=3)
    assert found != rates_of_equals(pools, 2, level, seed=4)
    assert min(found.problems, found.across) > 0.2
    assert rates_of_spreads(10, 2, 4, level, 3) == rates_of_spreads(10, 2, 4, level, 3)
    assert rates_of_spreads(10, 2, 4, level, 3) != rates_of_spreads(10, 2, 4, level, 4)


def test_values_that_are_all_tied_are_never_claimed_to_differ():
    rates = rates_of_equals([[np.zeros(20)]] * 7, 2, Levels(0.01, 0.035))
    assert rates[1:] == (0.0, 0.0, 0.0)


def test_trials_are_dealt_out_within_their_instance():
    apart = [np.zeros(6), np.ones(6)]  # dealt across instances, these would differ
    assert rates_of_equals([apart] * 9, 2, Levels(0.8, 0.8)).any == 0.0


def test_of_many_optimizers_twelve_are_simulated():
    rates = rates_of_equals([[np.arange(200.0)]], 100, Levels(0.9, 0.9))
    assert rates.studies == 1_000


def test_more_trials_detect_smaller_differences():
    found = [detectable_a12(trials, 0.05) for trials in (8, 16, 30, 100)]
    assert found == sorted(found, reverse=True)
    assert 0.5 < found[-1] < found[0] < 1
    assert detectable_a12(30, 0.05) < detectable_a12(30, 0.001)
    assert np.isnan(detectable_a12(1, 0.05))
    assert np.isnan(detectable_a12(5, 0.05))  # complete separation has 1/16


def test_more_trials_and_problems_detect_smaller_differences_over_problems():
    by_trials = [detectable_across(trials, 12, 0.05) for trials in (4, 10, 30)]
    assert by_trials == sorted(by_trials, reverse=True)
    assert 0.5 < by_trials[-1] < by_trials[0] < 1
    assert detectable_across(10, 24, 0.05) < by_trials[1]


@pytest.mark.filterwarnings("error")
def test_one_trial_a_cell_detects_nothing():
    assert np.isnan(detectable_across(1, 24, 0.05))


@pytest.mark.parametrize("tests", [0, 1, 30, 216])
@pytest.mark.parametrize("level", [0.05, 0.025])
def test_trials_to_separate_are_the_fewest(tests, level):
    trials, tests = trials_to_separate(tests, level), max(tests, 1)
    assert least_p(trials) * tests <= level < least_p(trials - 1) * tests
