"""Running times of a reference at precisions."""

import numpy as np
import pandas as pd

from bench.analysis import reference_times

KNOWN = pd.DataFrame({"problem": "f-d2", "precision": [1e2, 1.0, 1e-1, 1e-8], "ert": [1.0, 20.0, 30.0, 40.0]})


def times(precisions, known=KNOWN):
    return reference_times(known, {"mine": "f-d2"}, precisions)["ert"].tolist()


def test_a_precision_stands_for_the_next_harder_one_that_is_known():
    assert times([1e3, 1e2, 99.0, 1.0, 0.5, 0.1, 1e-3, 1e-8]) == [1.0, 1.0, 20.0, 20.0, 30.0, 30.0, 40.0, 40.0]
    assert times([10 ** (-5 / 5) * (1 - 1e-12)]) == [30.0]  # rounding


def test_a_precision_that_was_not_reached_is_infinite():
    assert times([1.0, 1e-3, 1e-8], KNOWN[:3]) == [20.0, np.inf, np.inf]


def test_harder_precisions_and_other_functions_are_unknown():
    assert np.isnan(times([1e-9])).all()
    found = reference_times(KNOWN, {"other": "g-d2"}, [1.0])
    assert found["ert"].isna().tolist() == [True]
    assert list(reference_times(KNOWN, {}, [1.0])) == ["problem", "precision", "ert"]
