"""Running times of a reference at precisions."""

import numpy as np
import pandas as pd
import pytest

from bench.analysis.reference import reference_times, runlength_targets

KNOWN = pd.DataFrame({"problem": "f-d2", "precision": [1e2, 1.0, 1e-1, 1e-8], "ert": [1.0, 20.0, 30.0, 40.0]})


def levels(precisions, problem="mine"):
    return pd.DataFrame({"problem": problem, "precision": precisions})


def times(precisions, known=KNOWN):
    return reference_times(known, {"mine": "f-d2"}, levels(precisions))["ert"].tolist()


def test_a_precision_stands_for_the_next_harder_one_that_is_known():
    assert times([1e3, 1e2, 99.0, 1.0, 0.5, 0.1, 1e-3, 1e-8]) == [1.0, 1.0, 20.0, 20.0, 30.0, 30.0, 40.0, 40.0]
    assert times([10 ** (-5 / 5) * (1 - 1e-12)]) == [30.0]  # rounding


def test_a_precision_that_was_not_reached_is_infinite():
    assert times([1.0, 1e-3, 1e-8], KNOWN[:3]) == [20.0, np.inf, np.inf]


def test_harder_precisions_and_other_functions_are_unknown():
    assert np.isnan(times([1e-9])).all()
    found = reference_times(KNOWN, {"other": "g-d2"}, levels([1.0], "other"))
    assert found["ert"].isna().tolist() == [True]
    assert list(reference_times(KNOWN, {}, levels([]))) == ["problem", "precision", "ert"]


def run_lengths(known=KNOWN, dimension=2):
    return runlength_targets(known, {"mine": "f-d2"}, {"mine": dimension})["precision"].tolist()


def test_a_target_by_running_length_is_the_next_precision_after_the_one_reached_within_it():
    steps = [1e2, 10**1.8, 10**1.6, 10**1.4, 10**1.2]
    known = pd.DataFrame({"problem": "f-d2", "precision": steps, "ert": [1.0, 2.0, 6.0, 19.0, 101.0]})
    assert run_lengths(known) == pytest.approx([10**1.8, 10**1.6, 10**1.4, 10**1.2, 10])  # the last one is forced
    assert run_lengths(known, 20) == pytest.approx([10**1.4, 10**1.2, 10, 10**0.8, 10**0.6])


def test_targets_by_running_length_end_at_the_hardest_precision_and_begin_at_the_easiest():
    assert run_lengths(KNOWN[3:]) == [1e-8] * 5
    late = KNOWN.assign(ert=KNOWN["ert"] * 1e9)  # nothing is reached within any of the budgets
    assert run_lengths(late) == pytest.approx([1e2, 10**1.8, 10**1.6, 10**1.4, 10**1.2])
    assert runlength_targets(KNOWN, {"mine": "g-d2"}, {"mine": 2}).empty
