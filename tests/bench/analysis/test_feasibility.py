"""Feasibility rates: counted by hand."""

import numpy as np
import pandas as pd

from bench.analysis import feasibility
from bench.contract.objective import Trace

INF = np.inf


def test_rates_and_the_median_first_feasible_evaluation():
    fun = {"a": [3.0, 2.0, INF, 1.0], "b": [INF, INF, 5.0], "c": []}
    first = {"a": [7, 3, None, 5], "b": [None, None, 9]}
    rows = [
        {"problem": "p", "optimizer": label, "trial": number, "status": "ok", "fun": value}
        for label, values in fun.items()
        for number, value in enumerate(values)
    ]
    rows.append({"problem": "p", "optimizer": "b", "trial": 3, "status": "failed", "fun": np.nan})
    rows.append({"problem": "free", "optimizer": "a", "trial": 0, "status": "ok", "fun": 1.0})
    frame = pd.DataFrame(rows)
    frame["optimizer"] = pd.Categorical(frame["optimizer"], categories=["a", "b", "c"])
    traces = {
        ("p", label, number): Trace(np.array([at, 50]), np.array([9.0, fun[label][number]]))
        for label, numbers in first.items()
        for number, at in enumerate(numbers)
        if at is not None
    }
    found = feasibility(frame, traces, ["p"])
    assert found["problem"].tolist() == ["p"] * 3
    assert found["trials"].tolist() == [4, 4, 0]
    assert found["feasible"].tolist() == [3, 1, 0]
    np.testing.assert_array_equal(found["rate"], [0.75, 0.25, np.nan])
    np.testing.assert_array_equal(found["first"], [6.0, INF, np.nan])  # of 3, 5, 7, inf: halfway from 5 to 7
    assert feasibility(frame, traces, []).empty
