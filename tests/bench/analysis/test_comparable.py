"""What of a study is compared, by hand: shared instances, known values at one budget, problems that work."""

import numpy as np
import pandas as pd

from bench.analysis.comparable import blames_problem, common_budgets, comparable
from bench.contract.objective import Trace

ALLOWED = {("p", "a"): 400, ("p", "b"): 100_000}


def trials(*rows, **columns):
    frame = pd.DataFrame(rows, columns=["problem", "optimizer", "trial", "fun", "nfev"])
    return frame.assign(**{"status": "ok", "error": None} | columns)


def keys(frame):
    return [*zip(frame["problem"], frame["optimizer"], frame["trial"], strict=True)]


class TestBudgets:
    def test_the_largest_budget_that_all_optimizers_with_trials_had(self):
        frame = pd.DataFrame({"problem": ["p", "p", "q"], "optimizer": ["a", "b", "b"]})
        allowed = {("p", "a"): 400, ("p", "b"): 100_000, ("q", "a"): 400, ("q", "b"): 100_000}
        assert common_budgets(frame, allowed) == {"p": 400, "q": 100_000}  # a has no trial on q
        assert common_budgets(frame, dict.fromkeys(allowed, 400)) == {}
        assert common_budgets(frame, {"p": 400, "q": 800}) == {}
        assert common_budgets(frame, 400) == {}

    def test_each_trial_has_the_value_that_it_had_then(self):
        frame = trials(
            ("p", "a", 0, 2.0, 400), ("p", "b", 0, 1.0, 100_000), ("p", "b", 1, 0.5, 300),
            ("p", "b", 2, np.nan, 90_000), ("p", "b", 3, 3.0, 100_000), ("p", "b", 4, np.inf, 500),
            status=["ok", "ok", "ok", "failed", "ok", "ok"],
        )  # fmt: skip
        traces = {
            ("p", "b", 0): Trace(np.array([10, 400, 401]), np.array([9.0, 5.0, 1.0])),
            ("p", "b", 3): Trace(np.array([500]), np.array([3.0])),
        }
        found = comparable(frame, traces, ALLOWED)
        assert found.common == {"p": 400}
        assert found.frame["fun"].tolist()[:3] == [2.0, 5.0, 0.5]
        assert np.isnan(found.frame["fun"].iloc[3])
        assert found.frame["fun"].tolist()[4:] == [np.inf, np.inf]  # 3 had no value by then
        assert not found.unknown

    def test_a_cell_with_a_value_that_is_unknown_there_is_left_out_whole(self):
        """Those that ended early are the lucky ones: to compare them alone is as wrong as to call the others lost."""
        frame = trials(
            ("p", "a", 0, 2.0, 400), ("p", "b", 0, 1.0, 300), ("p", "b", 1, 0.5, 90_000), ("p", "b", 2, 9.0, 1_000)
        )
        found = comparable(frame, {}, ALLOWED)
        assert keys(found.frame) == [("p", "a", 0)]
        assert found.unknown == {("p", "b"): 2}
        assert found.working is frame  # running times count it


class TestInstances:
    def test_those_count_that_all_optimizers_with_trials_share(self):
        rows = [("f", label, i, 1.0, 10) for label, some in (("a", (1, 2, 3)), ("b", (2, 3, 4))) for i in some]
        frame = trials(*rows, ("g", "a", 0, 1.0, 10), instance=[1, 2, 3, 2, 3, 4, np.nan])
        found = comparable(frame, {}, 10)
        assert keys(found.frame) == [("f", "a", 2), ("f", "a", 3), ("f", "b", 2), ("f", "b", 3), ("g", "a", 0)]
        assert found.instances == {"f": (2, 4)}


class TestFailures:
    def test_a_problem_whose_own_code_raised_in_any_trial_is_left_out(self):
        error = ["ProblemError: ValueError: no mass\nTraceback", None, "ValueError: my own", None]
        frame = trials(
            ("p", "a", 0, np.nan, 0), ("p", "b", 0, 1.0, 10), ("q", "a", 0, np.nan, 0), ("q", "b", 0, 1.0, 10),
            status=["failed", "ok", "failed", "ok"], error=error,
        )  # fmt: skip
        assert blames_problem(frame).tolist() == [True, False, False, False]
        found = comparable(frame, {}, 10)
        assert keys(found.frame) == keys(found.working) == [("q", "a", 0), ("q", "b", 0)]  # a loses q
        assert found.failed == {"p": (1, 2)}
