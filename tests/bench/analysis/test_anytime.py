"""Best-so-far curves, by hand."""

import warnings

import numpy as np
import pandas as pd
import pytest

from bench.analysis.anytime import best_so_far, convergence, evaluation_grid
from bench.objective import Trace

INF = float("inf")


def trace(*steps):
    evaluations, values = zip(*steps, strict=True) if steps else ((), ())
    return Trace(np.array(evaluations, dtype=np.int64), np.array(values, dtype=float))


def trials(*rows):
    return pd.DataFrame(rows, columns=["problem", "optimizer", "trial", "status"])


@pytest.fixture(autouse=True)
def _quiet():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


class TestBestSoFar:
    traces = (trace((1, 8.0), (10, 2.0)), trace((1, 4.0), (100, 0.0)))

    def test_grid_runs_from_one_to_the_budget(self):
        assert evaluation_grid(1).tolist() == [1]
        grid = evaluation_grid(60_000)
        assert (grid[0], grid[-1]) == (1, 60_000)
        assert (np.diff(grid) > 0).all()

    def test_median_by_hand(self):
        curve = best_so_far(self.traces, np.array([1, 10, 100]))
        assert curve["median"].tolist() == [6.0, 3.0, 1.0]
        assert curve["q1"].tolist() == [5.0, 2.5, 0.5]

    def test_failed_trials_count_as_infinite(self):
        curve = best_so_far(self.traces, np.array([1, 100]), failed=1)
        assert curve["median"].tolist() == [8.0, 2.0]
        assert curve["q3"].tolist() == [INF, INF]

    def test_an_empty_cell_has_no_curve(self):
        assert best_so_far([], np.array([1])).empty


TRACES = {
    ("p", "a", 0): trace((1, 8.0), (10, 2.0)),
    ("p", "a", 1): trace((1, 4.0), (100, 0.0)),
    ("p", "b", 0): trace((3, 1.0)),
}


class TestConvergence:
    def test_every_cell_by_hand(self):
        frame = trials(("p", "a", 0, "ok"), ("p", "a", 1, "ok"), ("p", "b", 0, "ok"))
        curves = convergence(frame, TRACES, evaluation_grid(100, 3))
        assert list(curves) == ["problem", "optimizer", "evaluations", "median", "q1", "q3"]
        a, b = (curves[curves["optimizer"] == name] for name in "ab")
        assert a["evaluations"].tolist() == [1, 10, 100]
        assert a["median"].tolist() == [6.0, 3.0, 1.0]
        assert b["median"].tolist() == b["q1"].tolist() == [INF, 1.0, 1.0]

    def test_a_failed_trial_counts_as_infinite_whatever_its_trace(self):
        frame = trials(("p", "a", 0, "ok"), ("p", "a", 1, "ok"), ("p", "a", 2, "timeout"))
        curves = convergence(frame, {**TRACES, ("p", "a", 2): trace((1, -1.0))}, evaluation_grid(100, 3))
        assert curves["median"].tolist() == [8.0, 4.0, 2.0]
        assert curves["q3"].tolist() == [INF] * 3

    def test_a_trial_without_a_trace_counts_as_infinite(self):
        frame = trials(("p", "b", 0, "ok"), ("p", "b", 1, "ok"))
        assert convergence(frame, TRACES, evaluation_grid(100, 3))["q1"].tolist() == [INF] * 3

    def test_the_studys_order_and_its_empty_cells(self):
        frame = trials(("p", "a", 0, "ok"), ("p", "b", 0, "ok"))
        categories = pd.Categorical(frame["optimizer"], categories=["c", "b", "a"])
        curves = convergence(frame.assign(optimizer=categories), TRACES, evaluation_grid(100))
        assert list(dict.fromkeys(curves["optimizer"])) == ["b", "a"]

    def test_nothing_at_all(self):
        assert convergence(trials(), {}, evaluation_grid(100)).empty
        curves = convergence(trials(("p", "a", 0, "failed")), {}, evaluation_grid(100, 3))
        assert curves["median"].tolist() == [INF] * 3
