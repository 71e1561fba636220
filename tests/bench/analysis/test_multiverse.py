"""The order under other analyses, by hand: an outlier parts median and mean, instances part what pools them."""

import numpy as np
import pandas as pd

from bench.analysis.multiverse import MEASURES, multiverse
from bench.objective import Trace


def study(cells):
    """Return the frame and the traces of {(optimizer, instance): (values after 10 evaluations, final values)}."""
    rows, traces = [], {}
    for (optimizer, instance), (early, last) in cells.items():
        for before, value in zip(early, last, strict=True):
            number = sum(key[1] == optimizer for key in traces)
            rows.append(
                {"problem": "p", "optimizer": optimizer, "trial": number, "status": "ok", "fun": value,
                 "instance": instance, "nfev": 100}
            )  # fmt: skip
            traces["p", optimizer, number] = Trace(np.array([1, 50]), np.array([before, value]))
    return pd.DataFrame(rows), traces


def firsts(found):
    """Return the optimizers that are first, by measure, sample and share."""
    first = found[found["rank"] == found.groupby(["measure", "sample", "share"])["rank"].transform("min")]
    return first.groupby(["measure", "sample", "share"])["optimizer"].agg("".join).to_dict()


def test_an_outlier_parts_the_mean_from_median_and_probability():
    frame, traces = study({("a", 1): ([9.0] * 3, [1.0, 1.0, 100.0]), ("b", 1): ([5.0] * 3, [2.0] * 3)})
    found = multiverse(frame, traces, {"p": 100}, "a", shares=(0.1, 1.0))
    assert firsts(found) == {
        ("median", "pooled", 0.1): "b", ("mean", "pooled", 0.1): "b", ("probability to end lower", "pooled", 0.1): "b",
        ("median", "pooled", 1.0): "a", ("mean", "pooled", 1.0): "b", ("probability to end lower", "pooled", 1.0): "a",
    }  # fmt: skip
    of_b = found[(found["optimizer"] == "b") & (found["share"] == 1.0)].set_index("measure")["behind"]
    assert of_b.to_dict() == {"median": 1.0, "mean": 0.0, "probability to end lower": 1.0}


def test_one_that_is_lower_on_most_instances_is_not_when_they_are_pooled():
    """a is lower by 1 on two instances, and higher by 30 on the third."""
    ends = {"a": (10.0, 20.0, 30.0), "b": (11.0, 21.0, 0.0)}
    cells = {(name, place): ([50.0] * 2, [value] * 2) for name in ends for place, value in enumerate(ends[name])}
    frame, traces = study(cells)
    found = multiverse(frame, traces, {"p": 100}, "a", shares=(1.0,))
    assert {(sample, first) for (_, sample, _), first in firsts(found).items()} == {
        ("pooled", "b"),
        ("by instance", "a"),
    }
    assert len(found) == 2 * 3 * 2


def test_ties_share_the_place_and_sets_of_targets_count_where_any_was_reached():
    frame, traces = study({(name, 1): ([5.0] * 2, [1.0] * 2) for name in "ab"})
    sets = pd.DataFrame(
        [("reached", 1, "a", 0.2, 2.0), ("reached", 1, "b", 0.4, 1.0), ("none", 1, "a", 0.0, 1.5),
         ("none", 1, "b", 0.0, 1.5)],
        columns=["set", "problems", "optimizer", "area", "rank"],
    )  # fmt: skip
    found = multiverse(frame, traces, {"p": 100}, "a", {1.0: sets}, shares=(1.0,))
    alike = dict.fromkeys([(measure, "pooled", 1.0) for measure in MEASURES], "ab")
    assert firsts(found) == alike | {("reached", "", 1.0): "b"}
    assert found.loc[(found["measure"] == "reached") & (found["optimizer"] == "b"), "behind"].tolist() == [0.0]
    assert set(found.loc[found["measure"] == "median", "behind"]) == {0.5}


def test_without_a_problem_that_all_have_there_is_no_analysis():
    frame, traces = study({("a", 1): ([5.0], [1.0])})
    more = frame.assign(optimizer="b", problem="q")
    assert multiverse(pd.concat([frame, more]), traces, {"p": 100, "q": 100}, "a").empty
