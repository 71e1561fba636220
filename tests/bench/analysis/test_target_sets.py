"""Sets of targets and AOCC, by hand on two trials."""

import numpy as np
import pandas as pd
import pytest

from bench.analysis.target_sets import aocc, target_table, targets, tolerance_times
from bench.study.targets import COCO_PRECISIONS
from tests.bench.analysis.test_anytime import TRACES as BEGUN
from tests.bench.analysis.test_anytime import trace

INF = float("inf")


TRACES = {("p", "a", 0): trace((1, 14.0), (5, 5.0)), ("p", "a", 1): trace((2, 6.0), (8, 4.1))}
FRAME = pd.DataFrame(
    [
        ("p", "a", 0, "ok", 5.0, 10, 11.0),
        ("p", "a", 1, "ok", 4.1, 10, 9.75),
        ("p", "a", 2, "failed", None, None, np.nan),
    ],
    columns=["problem", "optimizer", "trial", "status", "fun", "nfev", "size"],
)


class TestLadder:
    def test_where_no_optimum_is_known_the_lowest_value_found_stands_in(self):
        ladder = targets(BEGUN)
        assert list(ladder) == ["problem", "tau", "target", "reference", "known"]
        assert len(ladder) == 31
        assert not ladder["known"].any()
        assert set(ladder["reference"]) == {0.0}
        np.testing.assert_allclose(ladder["target"], 10 * ladder["tau"])

    def test_a_known_optimum_is_the_reference_of_a_longer_ladder(self):
        ladder = targets(BEGUN, {"p": -90.0})
        assert (len(ladder), ladder["known"].all(), set(ladder["reference"])) == (81, True, {-90.0})
        assert ladder["target"].iloc[[0, 10]].tolist() == [10.0, -80.0]

    @pytest.mark.parametrize("optima", [None, {"p": 3.0}, {"p": 4.0}])
    def test_where_trials_start_at_the_reference_it_is_the_only_target(self, optima):
        ladder = targets({("p", "a", 0): trace((1, 3.0)), ("p", "a", 1): trace((1, 3.0))}, optima)
        assert ladder[["tau", "target"]].to_numpy().tolist() == [[0.0, 3.0]]
        assert ladder["known"].tolist() == [optima == {"p": 3.0}]

    def test_an_optimum_that_a_trial_beat_gives_way_to_what_was_found(self):
        ladder = targets(BEGUN, {"p": 0.5})
        assert (len(ladder), ladder["known"].any(), set(ladder["reference"])) == (31, False, {0.0})
        near = targets({("p", "a", 0): trace((1, 5.0), (2, 1 - 1e-13))}, {"p": 1.0})
        assert (len(near), near["known"].all(), set(near["reference"])) == (81, True, {1.0})


class TestSets:
    @pytest.mark.parametrize(("optima", "reference"), [({"p": 4.0}, 4.0), ({}, 4.1), ({"p": 4.5}, 4.1)])
    def test_precisions_are_above_the_optimum_or_what_was_found(self, optima, reference):
        table = target_table("precisions", FRAME, TRACES, optima)
        assert table["tau"].tolist() == COCO_PRECISIONS.tolist()
        assert table["target"].tolist() == (reference + COCO_PRECISIONS).tolist()
        assert set(table["known"]) == {optima == {"p": 4.0}}

    def test_percentages_are_of_the_size_of_the_optimum(self):
        assert target_table(["50%", "25%"], FRAME, TRACES, {"p": 4.0})["target"].tolist() == [6.0, 5.0]
        below = {("p", "a", 0): trace((1, -3.0))}
        assert target_table(["50%"], FRAME, below, {"p": -4.0})["target"].tolist() == [-2.0]
        assert target_table(["50%"], FRAME, TRACES, {"p": 0.0}).empty


class TestTolerance:
    def test_the_time_is_when_the_best_point_was_found(self):
        hits = tolerance_times(FRAME, TRACES, {"p": {"size": (10.0, 0.5)}, "q": {}}, 10)
        wide = hits.pivot(index="trial", columns="tau", values="evaluations")
        assert wide[[2.0, 1.0, 0.5, 0.25]].to_numpy().tolist() == [[5, INF, INF, INF], [8, 8, 8, INF], [INF] * 4]
        assert hits.groupby("trial")["spent"].first().tolist() == [10, 10, 10]

    def test_all_metrics_have_to_be_within(self):
        expected = {"p": {"size": (10.0, 1.0), "never recorded": (1.0, 1.0)}}
        assert np.isinf(tolerance_times(FRAME, TRACES, expected, 10)["evaluations"]).all()


class TestAOCC:
    def test_a_plain_sum_over_all_evaluations(self):
        found = aocc(FRAME, TRACES, {"p": 4.0}, 10).iloc[0]
        total = 0.0
        for each in TRACES.values():
            for i in range(1, 11):
                y = each.at(np.array([i]))[0] - 4.0
                total += (1 - (np.clip(np.log10(y), -8, 2) + 8) / 10) / 10 if np.isfinite(y) else 0.0
        assert found["trials"] == 3
        assert found["aocc"] == pytest.approx(total / 3, rel=1e-12)
