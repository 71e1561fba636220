"""Who is faster by the clock, and up to which cost of an evaluation."""

import pandas as pd
import pytest

from bench import Results
from bench.topics.findings import Findings
from bench.topics.verdict import clock

COLUMNS = ["problem", "optimizer", "tau", "successes", "ert", "ert_s"]


@pytest.fixture
def findings(make, tmp_path):
    return Findings(Results(make(tmp_path / "s", ("p", "q", "r"))))


def timed(findings, overheads):
    """Set the seconds of each optimizer for an evaluation beside those of the objective, by problem and optimizer."""
    frame = findings.trials.whole
    keys = zip(frame["problem"], frame["optimizer"], strict=True)
    own = pd.Series([overheads[key] for key in keys], index=frame.index)
    findings.trials.__dict__["whole"] = frame.assign(
        objective_s=frame["nfev"] * 1e-7, wall_s=frame["nfev"] * (own + 1e-7)
    )
    rows = [
        (p, o, 1e-2, 3, ert, ert * (overheads[p, o] + 1e-7))
        for p in "pqr"
        for o, ert in (("a", 10.0), ("b", 20.0), ("c", 90.0))
    ]
    findings.anytime.__dict__["running_times"] = pd.DataFrame(rows, columns=COLUMNS)


def test_the_break_even_cost_is_that_at_which_both_take_as_long(findings):
    own = {"a": 4e-6, "b": 1e-6, "c": 1e-6}
    scale = {"p": 1.0, "q": 0.5, "r": 10.0}
    timed(findings, {(p, o): scale[p] * own[o] for p in "pqr" for o in "abc"})
    ert = pd.DataFrame({"a": [10.0] * 3, "b": [20.0] * 3}, index=list("pqr"))
    costs = clock.break_even(ert, clock.overhead(findings.trials.whole), "a", "b")
    for problem, cost in costs.items():  # 10 evaluations of a take as long as 20 of b
        assert 10 * (4e-6 * scale[problem] + cost) == pytest.approx(20 * (1e-6 * scale[problem] + cost))
    said = clock.clock(findings)
    assert (said.fastest, said.cost) == ("b", "2 us")
    assert said.sentence == (
        "b is faster by the clock than a as long as an evaluation takes less than 2 us (median of 3 problems; 1 to 20 "
        f"us): to {findings.anytime.target_set.at_length(1e-2)}, a has the lowest expected running time in "
        "evaluations on 3 of 3 problems, and b the lowest in seconds on 3."
    )


def test_nothing_is_said_where_the_order_stays_or_times_are_unknown(findings):
    timed(findings, {(p, o): 1e-6 for p in "pqr" for o in "abc"})
    assert clock.clock(findings) is None
    table = findings.anytime.running_times
    findings.anytime.__dict__["running_times"] = table.assign(ert_s=float("nan"))
    assert clock.clock(findings) is None
    findings.anytime.__dict__["running_times"] = table.head(0)
    assert clock.clock(findings) is None


def test_an_optimizer_that_is_faster_at_any_cost_has_no_break_even():
    ert = pd.DataFrame({"a": [10.0, 10.0, float("nan")], "b": [20.0, 5.0, 5.0]}, index=list("pqr"))
    overheads = pd.DataFrame({"a": [1e-6] * 3, "b": [1e-6] * 3}, index=list("pqr"))
    assert clock.break_even(ert, overheads, "a", "b").isna().all()
