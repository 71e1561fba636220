"""Values at the largest common budget, by hand."""

import numpy as np
import pandas as pd

from bench.analysis.common_budget import at_budget, common_budgets
from bench.objective import Trace


def test_the_largest_budget_that_all_optimizers_with_trials_had():
    frame = pd.DataFrame({"problem": ["p", "p", "q"], "optimizer": ["a", "b", "b"]})
    allowed = {("p", "a"): 400, ("p", "b"): 100_000, ("q", "a"): 400, ("q", "b"): 100_000}
    assert common_budgets(frame, allowed) == {"p": 400, "q": 100_000}  # a has no trial on q
    assert common_budgets(frame, dict.fromkeys(allowed, 400)) == {}
    assert common_budgets(frame, {"p": 400, "q": 800}) == {}
    assert common_budgets(frame, 400) == {}


def test_each_trial_has_the_value_that_it_had_then_or_is_left_out():
    rows = [
        ("a", 0, "ok", 2.0, 400), ("b", 0, "ok", 1.0, 100_000), ("b", 1, "ok", 0.5, 300), ("b", 2, "ok", 0.1, 90_000),
        ("b", 3, "failed", np.nan, 90_000), ("b", 4, "ok", 3.0, 100_000), ("b", 5, "ok", np.inf, 500),
    ]  # fmt: skip
    frame = pd.DataFrame(rows, columns=["optimizer", "trial", "status", "fun", "nfev"]).assign(problem="p")
    traces = {
        ("p", "b", 0): Trace(np.array([10, 400, 401]), np.array([9.0, 5.0, 1.0])),
        ("p", "b", 4): Trace(np.array([500]), np.array([3.0])),
    }
    found = at_budget(frame, traces, {"p": 400}).set_index(["optimizer", "trial"])["fun"]
    # b 2 spent more and left no trace, so that its value at 400 is unknown; b 4 had none by then
    assert found.drop(("b", 3)).to_dict() == {
        ("a", 0): 2.0, ("b", 0): 5.0, ("b", 1): 0.5, ("b", 4): np.inf, ("b", 5): np.inf,
    }  # fmt: skip
    assert np.isnan(found["b", 3])
