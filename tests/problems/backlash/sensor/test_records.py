"""Estimates for programs: JSON objects, and rows of a CSV file."""

import json
import math
from pathlib import Path

import pytest

from problems.backlash.sensor.batch import Estimated, Failed
from problems.backlash.sensor.estimate import Settings
from problems.backlash.sensor.records import csv_rows, json_objects
from problems.backlash.sensor.trend import joints_of


def test_csv_has_a_column_for_each_end_of_an_interval(make_estimate):
    good = Estimated(Path("g"), make_estimate(0.001, notes=("few turns", "drift")))
    first, second = csv_rows([good, Failed(Path("b"), "no")], joints_of([good], Settings()))
    assert (first["interval_rad_low"], first["interval_rad_high"]) == pytest.approx((0.0009, 0.0011))
    assert (first["notes"], first["limit_status"], first["limit_interval_low"]) == ("few turns; drift", "unknown", None)
    assert second == {"file": "b", "error": "no"}


def test_an_object_holds_only_what_json_knows(make_estimate):
    nan = (math.nan, math.nan)
    estimate = make_estimate(math.nan, amplitude_interval_rps=(0.1, math.inf), interval_rad=nan, amplitude_rps=1.0)
    outcome, failed = Estimated(Path("a.csv"), estimate), Failed(Path("b.csv"), "no", "J5")
    content, failure = json.loads(
        json.dumps(json_objects([outcome, failed], joints_of([outcome], Settings())), allow_nan=False)
    )
    assert list(content)[:15] == [
        "file", "joint", "date", "amplitude_rps", "backlash_rad", "interval_rad", "rmse_rps", "verdict",
        "A", "t0", "tau", "omega", "v_t", "T1", "T2",
    ]  # fmt: skip
    assert content["backlash_rad"] is None
    assert content["interval_rad"] == [None, None]
    assert content["amplitude_interval_rps"] == [0.1, None]
    assert failure == {"file": "b.csv", "joint": "J5", "error": "no"}


def test_every_recording_has_its_joint_date_trend_and_the_date_of_the_limit(make_estimate):
    outcomes = [
        Estimated(Path(f"cell/2024-{month:02}.csv"), make_estimate(0.0009 + 0.0001 * month), joint="J4")
        for month in range(1, 9)
    ]
    first, *_, last = json_objects(outcomes, joints_of(outcomes, Settings()))
    assert (first["joint"], first["date"], last["date"]) == ("J4", "2024-01", "2024-08")
    assert first["trend"] == last["trend"]
    assert first["trend"] | {"slope": 0, "interval": 0, "p_value": 0} == {
        "quantity": "backlash_rad", "per": "month", "slope": 0, "interval": 0, "p_value": 0, "significant": True,
    }  # fmt: skip
    assert first["trend"]["slope"] == pytest.approx(1e-4)
    assert first["limit"] == {"status": "predicted", "date": "2024-12", "interval": ["2024-12", "2024-12"]}
    (row, *_) = csv_rows(outcomes, joints_of(outcomes, Settings()))
    assert (row["trend_slope"], row["limit_date"]) == (first["trend"]["slope"], "2024-12")
