"""Best-so-far curves, targets, hitting times and what follows: by hand on tiny traces, and as properties."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.analysis.anytime import convergence, ecdf, evaluation_grid, expected_running_time, hitting_times
from bench.analysis.target_sets import targets
from bench.contract.objective import Trace

pytestmark = pytest.mark.filterwarnings("error", "default::ResourceWarning")
INF = float("inf")
BUDGET = 100


def trace(*steps):
    evaluations, values = zip(*steps, strict=True) if steps else ((), ())
    return Trace(np.array(evaluations, dtype=np.int64), np.array(values, dtype=float))


def trials(*rows):
    return pd.DataFrame(rows, columns=["problem", "optimizer", "trial", "status", "nfev"])


# f_0 is 10, the lowest value 0: the target of tau is 10 tau. "a" has one success at 0.1 and one failed trial.
TRACES = {
    ("p", "a", 0): trace((1, 10.0), (5, 1.0), (20, 0.0)),
    ("p", "a", 1): trace((1, 12.0), (50, 5.0)),
    ("p", "b", 0): trace((2, 10.0), (40, 0.5)),
    ("p", "b", 1): trace((1, 9.0), (8, 1.0)),
}
FRAME = trials(
    ("p", "a", 0, "ok", 100.0),
    ("p", "a", 1, "ok", 60.0),
    ("p", "a", 2, "failed", None),
    ("p", "b", 0, "ok", 100.0),
    ("p", "b", 1, "ok", 100.0),
)
HITS = hitting_times(FRAME, TRACES, targets(TRACES), BUDGET)


class TestHittingTimes:
    def test_by_hand(self, one):
        assert list(HITS) == ["problem", "optimizer", "trial", "tau", "target", "evaluations", "spent"]
        assert len(HITS) == 5 * 31
        times = HITS[np.isclose(HITS["tau"], 0.1)].set_index(["optimizer", "trial"])["evaluations"]
        assert times.to_dict() == {("a", 0): 5, ("a", 1): INF, ("a", 2): INF, ("b", 0): 40, ("b", 1): 8}
        assert one(HITS, optimizer="a", trial=1, tau=1.0)["evaluations"] == 50
        assert one(HITS, optimizer="b", trial=0, tau=1.0)["evaluations"] == 2

    def test_a_failed_trial_reached_nothing_and_spent_the_budget(self):
        traces = {**TRACES, ("p", "a", 2): trace((1, 0.0))}
        hits = hitting_times(FRAME.assign(nfev=3.0), traces, targets(TRACES), BUDGET)
        failed = hits[hits["trial"] == 2]
        assert np.isinf(failed["evaluations"]).all()
        assert set(failed["spent"]) == {BUDGET}
        assert set(hits.loc[hits["trial"] != 2, "spent"]) == {3.0}


class TestExpectedRunningTime:
    def test_by_hand(self, one):
        ert = expected_running_time(HITS)
        assert list(ert) == ["problem", "optimizer", "tau", "target", "trials", "successes", "ert"]
        a = one(ert, optimizer="a", tau=0.1)
        assert (a.target, a.trials, a.successes, a.ert) == (1.0, 3, 1, 5 + 60 + 100)
        b = one(ert, optimizer="b", tau=0.1)
        assert (b.trials, b.successes, b.ert) == (2, 2, (40 + 8) / 2)
        assert one(ert, optimizer="b", tau=0.001).ert == INF

    @pytest.mark.parametrize("categorical", [False, True])
    def test_in_any_order_of_the_rows_against_a_plain_sum(self, categorical):
        rng = np.random.default_rng(8)
        hits = HITS.assign(evaluations=rng.choice([3.0, 7.0, INF], len(HITS))).sample(frac=1, random_state=1)
        if categorical:
            hits["optimizer"] = pd.Categorical(hits["optimizer"], ["b", "a"])
        for row in expected_running_time(hits).itertuples():
            own = hits[(hits["optimizer"] == row.optimizer) & (hits["tau"] == row.tau)]
            reached = np.isfinite(own["evaluations"])
            paid = own["evaluations"].where(reached, own["spent"]).sum()
            assert (row.trials, row.successes) == (len(own), reached.sum())
            assert row.ert == pytest.approx(paid / reached.sum() if reached.any() else INF)


class TestShares:
    grid = np.array([1, 5, 20, 100])

    def test_ecdf_by_hand(self):
        table = ecdf(HITS, self.grid)
        assert list(table) == ["optimizer", "evaluations", "fraction"]
        # Of 3 x 31 pairs, "a" reached in trial 0 one target at once, those down to tau = 0.1 by 5 and all by 20
        # evaluations, and in trial 1 those down to tau = 0.5012 by 50.
        a = table.loc[table["optimizer"] == "a", "fraction"] * 93
        np.testing.assert_allclose(a, [1, 11, 31, 31 + 4])

    def test_every_problem_weighs_the_same_whatever_its_trials_and_ladder(self):
        frame = trials(("p", "a", 0, "ok", 9), ("p", "a", 1, "ok", 9), ("q", "a", 0, "ok", 9))
        traces = {
            ("p", "a", 0): trace((1, 2.0), (3, 1.0)),
            ("p", "a", 1): trace((1, 2.0), (3, 1.0)),
            ("q", "a", 0): trace((1, 3.0)),
        }
        hits = hitting_times(frame, traces, targets(traces, {"q": 0.0}), BUDGET)
        assert ecdf(hits, np.array([9]))["fraction"].item() == pytest.approx((1 + 1 / 81) / 2)


@st.composite
def studies(draw):
    """A frame and traces of two problems and two optimizers, failures and empty cells included."""
    rows, traces = [], {}
    for problem in "pq":
        for optimizer in "ab":
            for trial in range(draw(st.integers(0, 3))):
                steps = draw(st.integers(0, 5))
                at = sorted(draw(st.sets(st.integers(1, BUDGET), min_size=steps, max_size=steps)))
                values = sorted(draw(st.sets(st.floats(-1e6, 1e6), min_size=steps, max_size=steps)), reverse=True)
                status = draw(st.sampled_from(["ok", "ok", "ok", "failed"]))
                nfev = draw(st.integers(max(at, default=1), BUDGET))
                rows.append((problem, optimizer, trial, status, nfev if status == "ok" else None))
                if status == "ok":
                    traces[problem, optimizer, trial] = trace(*zip(at, values, strict=True))
    return trials(*rows), traces, draw(st.sampled_from([{}, {"p": -1e6}]))


class TestProperties:
    @settings(max_examples=25)
    @given(studies())
    def test_of_every_study(self, study):
        frame, traces, optima = study
        hits = hitting_times(frame, traces, targets(traces, optima), BUDGET)
        for (problem, optimizer, trial), own in hits.groupby(["problem", "optimizer", "trial"]):
            assert own["tau"].is_monotonic_decreasing
            assert own["evaluations"].is_monotonic_increasing
            found = traces.get((problem, optimizer, trial), trace())
            reached = own[np.isfinite(own["evaluations"])]
            assert (found.at(reached["evaluations"]) <= reached["target"]).all()
            assert (found.at(reached["evaluations"] - 1) > reached["target"]).all()
        ert = expected_running_time(hits)
        fastest = hits.groupby(["problem", "optimizer", "tau"])["evaluations"].min()
        for row in ert[ert["trials"] > 0].itertuples():
            assert row.ert >= fastest[row.problem, row.optimizer, row.tau]
            assert np.isinf(row.ert) == (row.successes == 0)
        curves = ecdf(hits, np.arange(BUDGET + 1))
        for optimizer, curve in curves.groupby("optimizer"):
            own = hits[hits["optimizer"] == optimizer]
            share = np.isfinite(own["evaluations"]).groupby(own["problem"]).mean().mean()
            assert curve["fraction"].is_monotonic_increasing
            assert curve["fraction"].iloc[0] == 0
            assert curve["fraction"].iloc[-1] == pytest.approx(share)


CURVES = {
    ("p", "a", 0): trace((1, 8.0), (10, 2.0)),
    ("p", "a", 1): trace((1, 4.0), (100, 0.0)),
    ("p", "b", 0): trace((3, 1.0)),
}


def ended(*rows):
    return trials(*((*row, None) for row in rows))


class TestConvergence:
    def test_every_cell_by_hand(self):
        frame = ended(("p", "a", 0, "ok"), ("p", "a", 1, "ok"), ("p", "b", 0, "ok"))
        curves = convergence(frame, CURVES, evaluation_grid(100, 3))
        assert list(curves) == ["problem", "optimizer", "evaluations", "median", "q1", "q3"]
        a, b = (curves[curves["optimizer"] == name] for name in "ab")
        assert a["evaluations"].tolist() == [1, 10, 100]
        assert a["median"].tolist() == [6.0, 3.0, 1.0]
        assert b["median"].tolist() == b["q1"].tolist() == [INF, 1.0, 1.0]
