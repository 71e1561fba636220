"""The levels that a design gives, the rates of false claims that they leave, and what they let a study find."""

import numpy as np
import pytest

from bench.analysis.direction import least_p
from bench.analysis.error_rates import (
    detectable_a12,
    detectable_across,
    levels,
    trials_to_separate,
)

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
