"""Running times and their spread: by hand, against plain loops, and against cocopp's own functions."""

import json
from importlib.util import find_spec

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from bench.analysis.anytime import expected_running_time
from bench.analysis.running_time import Batch, in_seconds, running_times, separably_fastest, simulated_restarts
from tests.bench.formats.made import read

INF = float("inf")


def hits_of(cells, spent=100.0, tau=1.0):
    """Build hitting times of one target from {(problem, optimizer): times}."""
    rows = [(*cell, i, tau, tau, time, spent) for cell, times in cells.items() for i, time in enumerate(times)]
    columns = ["problem", "optimizer", "trial", "tau", "target", "evaluations", "spent"]
    return pd.DataFrame(rows, columns=columns).astype({"evaluations": float, "spent": float})


def batch_of(times, spent):
    reached = np.isfinite(times)
    paid = np.where(reached, times, spent)[np.newaxis, :, np.newaxis]
    one = np.ones((1, 1))
    return Batch([("p", "a")], one, one, paid, reached[np.newaxis, :, np.newaxis], most=100 * one)


MIXED = hits_of({("p", "a"): [10, 20, INF], ("p", "b"): [INF, INF], ("q", "b"): [7.0], ("q", "a"): [3, 5, 4, 8]})


class TestRunningTimes:
    def test_ert_and_successes_are_those_of_the_anytime_view(self):
        own, other = running_times(MIXED), expected_running_time(MIXED)
        assert own["ert"].tolist() == [65.0, INF, 5.0, 7.0]
        merged = own.merge(other[other["trials"] > 0], on=["problem", "optimizer", "tau"])
        assert (merged["ert_x"] == merged["ert_y"]).all()
        assert (merged["successes_x"] == merged["successes_y"]).all()
        assert own[["problem", "optimizer"]].to_numpy().tolist() == [list(cell) for cell in ("pa", "pb", "qa", "qb")]

    def test_the_interval_combines_those_of_its_three_parts(self):
        times, spent = [10, 30, 35, 45, INF, INF, INF], [100, 100, 100, 100, 80, 100, 90]
        hits = hits_of({("p", "a"): times}).assign(spent=spent, budget=100.0)
        row = running_times(hits).iloc[0]
        ends = []
        for share, sign in ((0.975, -1), (0.025, 1)):
            chance = stats.beta.ppf(share, 4.5, 3.5)  # Jeffreys
            time, time_reach = np.mean(times[:4]), stats.sem(times[:4]) * stats.t.ppf(0.975, 3)
            cost, cost_reach = np.mean(spent[4:]), stats.sem(spent[4:]) * stats.t.ppf(0.975, 2)
            cost_reach = min(cost_reach, 100 - cost) if sign > 0 else cost_reach  # a trial costs 100 at most
            parts = time_reach, cost * ((1 - chance) / chance - 3 / 4), cost_reach * 3 / 4
            ends.append(time + 3 / 4 * cost + sign * np.sqrt(np.square(parts).sum()))
        assert [row.low, row.high] == pytest.approx(ends)

    def test_a_failure_may_cost_the_whole_budget_where_none_was_seen(self):
        hits = hits_of({("p", "a"): [10, 11, 12, 13, 14]}, spent=14.0)
        row = running_times(hits.assign(budget=1000.0)).iloc[0]
        share = 1 - stats.beta.ppf(0.025, 5.5, 0.5)
        assert share == pytest.approx(0.38, abs=0.01)  # this share of trials may fail
        assert row.high == pytest.approx(row.ert + 1000 * share / (1 - share), rel=0.01)
        assert 9 < row.low < row.ert == 12
        assert running_times(hits).iloc[0].high < 14 + 14 * share / (1 - share)  # no trial is known to cost more
        other = pd.concat([hits, hits_of({("p", "b"): [INF]}, spent=1000.0)])
        assert running_times(other).iloc[0].high == row.high

    @pytest.mark.parametrize("n", [5, 10, 30])
    def test_intervals_hold_the_true_value_where_nine_of_ten_trials_succeed(self, n):
        rng, cells = np.random.default_rng(n), 2000
        times = rng.exponential(1.0, (cells, n))
        budget = -np.log(0.1)
        cells_of = {(f"p{i}", "a"): own for i, own in enumerate(np.where(times <= budget, times, INF))}
        hits = hits_of(cells_of, spent=budget)
        table = running_times(hits.assign(budget=budget))
        true = 1.0  # an exponential time has no memory, so starting again costs nothing
        # a percentile bootstrap of these cells: 0.77, 0.86, 0.93
        assert ((table["low"] <= true) & (true <= table["high"])).mean() >= 0.94


class TestSeconds:
    frame = pd.DataFrame(
        [("p", "a", 0, "ok", 100, 1.0), ("p", "a", 1, "ok", 100, 3.0), ("p", "a", 2, "failed", None, None)],
        columns=["problem", "optimizer", "trial", "status", "nfev", "wall_s"],
    )

    def test_at_each_trial_s_own_pace(self):
        times = in_seconds(hits_of({("p", "a"): [10, 20, INF]}), self.frame)
        assert times["evaluations"].tolist() == pytest.approx([0.1, 0.6, INF])
        assert times["spent"].tolist() == pytest.approx([1.0, 3.0, 2.0])  # a failed one: the median pace, whole budget
        assert running_times(times)["ert"].tolist() == pytest.approx([2.7 / 2])
        known = in_seconds(hits_of({("p", "a"): [10, 20, INF]}).assign(budget=200.0), self.frame)
        assert known["budget"].tolist() == pytest.approx([2.0, 6.0, 4.0])


COCOPP = """
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import cocopp
import numpy as np
tools, found = cocopp.toolsstats, []
for times in json.loads(sys.argv[3]):
    reached = np.array([abs(each) for each in times if each > 0], dtype=float)
    failed = np.array([abs(each) for each in times if each < 0], dtype=float)
    rng = np.random.default_rng(1)
    drawn = tools.simulated_evals(
        np.hstack([reached, failed]), len(failed), 1005,
        randint=lambda low, high, size: np.tile(np.arange(high), -(-size // high))[:size],
        randintrest=rng.integers,
    )
    np.random.seed(1)
    own = tools.drawSP(reached, failed, (10, 50, 90), 15 * 6700)[0]
    ert = tools.sp(np.hstack([reached, failed]), issuccessful=[True] * len(reached) + [False] * len(failed))[0]
    found.append({"ert": ert, "drawn": list(map(float, drawn)), "own": [float(own[0]), float(own[-1])],
                  "percentiles": [float(each) for each in tools.prctile(drawn, (10, 90), issorted=True)]})
print("\\n" + json.dumps(found))
"""


@pytest.mark.skipif(find_spec("cocopp") is None, reason="compares with cocopp")
@pytest.mark.slow
def test_simulated_restarts_and_dispersion_are_cocopp_s(tmp_path):
    rng = np.random.default_rng(7)
    cells = []
    for successes in (15, 14, 8, 3, 1):
        times = rng.integers(10, 3000, 15)
        cells.append([int(time) if i < successes else -3000 - int(time) for i, time in enumerate(times)])
    for own, theirs in zip(cells, read(COCOPP, tmp_path, tmp_path, json.dumps(cells)), strict=True):
        times = np.array([time if time > 0 else INF for time in own], dtype=float)
        hits = hits_of({("p", "a"): times}).assign(spent=np.abs(own).astype(float))
        row = running_times(hits, 1005).iloc[0]
        drawn = simulated_restarts(batch_of(times, np.abs(own)), 1005, np.random.default_rng(1))
        assert sorted(drawn.ravel()) == theirs["drawn"]
        assert [row.p10, row.p90] == theirs["percentiles"]
        assert row.ert == theirs["ert"]
        # beside cocopp's own draws, many of them: they differ by what a thousand draws differ
        assert [row.p10, row.p90] == pytest.approx(theirs["own"], rel=0.12)


class TestFastest:
    def test_the_fastest_is_marked_where_it_beats_each_other_one(self):
        quick, slow, never = [10.0 + i for i in range(15)], [100.0 + i for i in range(15)], [INF] * 15
        cells = {("p", "a"): quick, ("p", "b"): slow, ("q", "a"): slow, ("q", "b"): [*slow[1:], 99.0],
                 ("r", "a"): never, ("r", "b"): never}  # fmt: skip
        (row,) = separably_fastest(hits_of(cells)).to_dict("records")
        assert (row["problem"], row["optimizer"]) == ("p", "a")
        assert row["p"] == 2 * 2.0**-14  # that of complete separation; r is reached by none
        both = pd.concat([hits_of(cells), hits_of(cells).assign(tau=0.5)])
        assert separably_fastest(both)["p"].tolist() == pytest.approx([2 * row["p"], 2 * row["p"]], rel=0.3)

    def test_a_rival_that_is_no_slower_or_few_trials_leave_none(self):
        quick, slow = [10.0 + i for i in range(15)], [100.0 + i for i in range(15)]
        assert separably_fastest(hits_of({("p", "a"): quick, ("p", "b"): quick, ("p", "c"): slow})).empty
        few = {(f"p{i}", each): times[:4] for i in range(24) for each, times in (("a", quick), ("b", slow))}
        assert separably_fastest(hits_of(few)).empty
        assert separably_fastest(hits_of({("p", "a"): quick})).empty
        enough = {("q", "a"): quick, ("q", "b"): slow}  # beside problems that are left out before any test
        assert separably_fastest(hits_of(few | enough))["problem"].tolist() == ["q"]
