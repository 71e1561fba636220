"""What its tests let a study find."""

import numpy as np

from bench.analysis.power import detectable_a12, detectable_across


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
