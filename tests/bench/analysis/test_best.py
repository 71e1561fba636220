"""The best point of each problem."""

import numpy as np
import pandas as pd

from bench.analysis.best import best


def test_it_is_the_first_run_with_the_lowest_value_and_its_point_by_the_variables_of_the_problem():
    frame = pd.DataFrame(
        {
            "problem": ["p", "p", "p", "q", "q", "r"], "optimizer": ["a", "b", "b", "a", "b", "a"],
            "trial": [0, 0, 1, 0, 0, 0], "status": ["ok", "ok", "ok", "ok", "failed", "ok"],
            "fun": [2.0, 1.0, 1.0, 5.0, None, np.inf], "x_u": [0.1, 0.2, 0.3, 0.4, None, 0.0],
            "x_v": [1.0, 2.0, 3.0, None, None, None],
        }
    )  # fmt: skip
    assert best(frame) == [("p", 1.0, "b", 0, {"u": 0.2, "v": 2.0}), ("q", 5.0, "a", 0, {"u": 0.4})]
    assert best(frame.iloc[:0]) == []
