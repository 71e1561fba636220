"""Ranks after shares of the budget, by hand; and the budget left unused."""

import numpy as np
import pytest

from bench import Trace
from bench.analysis.cells import summarise
from bench.analysis.pairwise import pairwise_tests
from bench.analysis.stages import earlier_leads, stage_ranks, unused_budget
from bench.analysis.standings import standings

pytestmark = pytest.mark.filterwarnings("error", "default::ResourceWarning")


def traces_of(curves):
    return {
        (problem, optimizer, trial): Trace(np.array([1, 10, 100]), np.array(values, dtype=float))
        for (problem, optimizer), own in curves.items()
        for trial, values in enumerate(own)
    }


def test_the_lead_changes_over_the_budget(frame_of):
    curves = {("p", "quick"): [[5, 4, 3], [5, 4, 3.5]], ("p", "late"): [[9, 8, 1], [9, 8, 1.5]]}
    frame = frame_of({cell: [values[-1] for values in own] for cell, own in curves.items()})
    found = stage_ranks(frame, traces_of(curves), {"p": 100}, (0.01, 0.5, 1.0))
    assert found["evaluations"].unique().tolist() == [1, 50, 100]
    ranks = found.pivot(index="share", columns="optimizer", values="rank")
    assert ranks["quick"].tolist() == [1.0, 1.0, 2.0]
    assert ranks["late"].tolist() == [2.0, 2.0, 1.0]


def test_the_last_stage_has_the_ranks_of_the_results(random_frame):
    frame = random_frame(3)
    traces = {
        (row.problem, row.optimizer, row.trial): Trace(np.array([1]), np.array([row.fun]))
        for row in frame[frame["status"] == "ok"].itertuples()
    }
    found = stage_ranks(frame, traces, {f"p{i}": 10 for i in range(3)}, (1.0,))
    wanted = standings(summarise(frame), pairwise_tests(frame))
    assert found["rank"].tolist() == wanted["rank"].tolist()


@pytest.fixture
def by_instance(frame_of):
    """Return trials on two instances that differ more than optimizers do, whose ranks need them apart, and traces."""
    fun = {"a": [1, 2, 11, 12, 13, 14], "b": [1.5, 2.5, 3.5, 4.5, 11.5, 12.5], "c": [1.2, 9, 9, 11.2, 11.6, 19]}
    instances = [1, 1, 2, 2, 2, 2, 1, 1, 1, 1, 2, 2, 1, 1, 1, 2, 2, 2]
    frame = frame_of({("p", name): values for name, values in fun.items()}, instance=instances)
    return frame, traces_of({("p", name): [[value] * 3 for value in values] for name, values in fun.items()})


def test_pooled_instances_are_ranked_by_instance_as_the_results_are(by_instance):
    frame, traces = by_instance
    found = stage_ranks(frame, traces, {"p": 100}, (0.1, 1.0))
    wanted = standings(summarise(frame), pairwise_tests(frame))["rank"].tolist()
    assert found["rank"].tolist() == wanted * 2
    assert stage_ranks(frame.drop(columns="instance"), traces, {"p": 100}, (1.0,))["rank"].tolist() != wanted


def test_an_earlier_lead_is_tested_by_instance_as_the_results_are(by_instance):
    frame, traces = by_instance
    found = earlier_leads(frame, traces, {"p": 100}, "b", shares=(0.1, 1.0)).set_index("optimizer")
    pairs = pairwise_tests(frame)
    (pair,) = pairs[(pairs["first"] == "a") & (pairs["second"] == "b")].to_dict("records")
    assert found.loc["a", ["probability", "p"]].tolist() == pytest.approx([pair["a12"], pair["p"]])


def test_failed_trials_and_those_without_a_trace_lose(frame_of):
    frame = frame_of({("p", "a"): [None, None], ("p", "b"): [1.0, 1.0]})
    traces = traces_of({("p", "a"): [[5, 4, 3]] * 2, ("p", "b"): [[9, 8, 7]] * 2})
    assert stage_ranks(frame, traces, {"p": 100}, (1.0,))["rank"].tolist() == [2.0, 1.0]
    assert stage_ranks(frame, {}, {"p": 100}, (1.0,))["rank"].tolist() == [1.5, 1.5]


def test_problems_that_an_optimizer_lacks_have_no_row(frame_of):
    frame = frame_of({("p", "a"): [1.0], ("q", "a"): [1.0], ("q", "b"): [2.0]})
    assert set(stage_ranks(frame, {}, {"p": 9, "q": 9}, (1.0,))["problem"]) == {"q"}
    assert stage_ranks(frame_of({}), {}, {}).empty


def test_unused_budget(frame_of):
    frame = frame_of({("p", "a"): [1.0, 1.0, None], ("p", "b"): [1.0]}, nfev=[50, 100, 10, 99.5], stop="tolfun")
    found = unused_budget(frame, 100).set_index("optimizer")
    assert found.loc["a"].tolist() == [2, 0.25, 0.5]
    assert found.loc["b"].tolist() == pytest.approx([1, 0.005, 0.0])
    good = unused_budget(frame.assign(stop=["target", "budget", None, "target"]), 100).set_index("optimizer")
    assert good.loc["a"].tolist() == [2, 0.0, 0.0]


def leads(frame_of, early, late, rivals=1, trials=20):
    """Return who leads on two problems where rivals begin at ``early`` and end at ``late``, the first at 5 and 0."""
    curves = {
        (problem, f"rival {number}"): [[early + i / 100, early, late] for i in range(trials)]
        for problem in "pq"
        for number in range(rivals)
    }
    curves |= {(problem, "first"): [[5 + i / 100, 5, 0] for i in range(trials)] for problem in "pq"}
    frame = frame_of({cell: [values[-1] for values in own] for cell, own in curves.items()})
    return earlier_leads(frame, traces_of(curves), dict.fromkeys("pq", 100), "first", shares=(0.01, 1.0))


def test_a_lead_at_a_smaller_budget_is_shown_by_its_test(frame_of):
    (row,) = leads(frame_of, 4, 9).to_dict("records")
    assert (row["share"], row["optimizer"], row["probability"], row["shown"]) == (0.01, "rival 0", 1.0, True)
    assert not leads(frame_of, 6, 9)["shown"].any()  # the leader leads there, too
    assert leads(frame_of, 5, 9)["probability"].tolist() == [0.5]


def test_a_lead_is_not_shown_by_fewer_trials_than_its_level_needs(frame_of):
    """Complete separation in n trials on two problems has p = 2^(1 - 2 n), which is adjusted for all rivals."""
    for trials, rivals, shown in ((4, 1, False), (5, 1, True), (5, 2, True), (5, 3, False)):
        assert leads(frame_of, 4, 9, rivals, trials)["shown"].all() == shown
    assert leads(frame_of, 4, 9, trials=1)["p"].tolist() == [1.0]


def test_without_rivals_or_complete_problems_nothing_leads(frame_of):
    assert earlier_leads(frame_of({("p", "a"): [1.0]}), {}, {"p": 9}, "a").empty
    assert earlier_leads(frame_of({("p", "a"): [1.0], ("q", "b"): [1.0]}), {}, {"p": 9, "q": 9}, "a").empty


def test_the_test_at_a_stage_is_that_of_its_values(frame_of):
    rng = np.random.default_rng(4)
    curves = {("p", label): np.sort(rng.random((12, 3)))[:, ::-1] for label in "ab"}
    frame = frame_of({cell: [values[-1] for values in own] for cell, own in curves.items()})
    for share, place in ((0.01, 0), (0.1, 1)):
        at_stage = frame_of({cell: own[:, place] for cell, own in curves.items()})
        (pair,) = pairwise_tests(at_stage).to_dict("records")
        (row,) = earlier_leads(frame, traces_of(curves), {"p": 100}, "b", shares=(share, 1.0)).to_dict("records")
        assert row["probability"] == pytest.approx(pair["a12"])
        assert row["p"] == pytest.approx(pair["p"])
