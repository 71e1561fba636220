"""Estimates, and the trends of their joints, for programs: as JSON objects and as the rows of a CSV file."""

import math
from collections.abc import Iterable

from bench.helpers import Json, JsonObject
from problems.backlash.sensor.batch import Estimated, Failed, Outcome
from problems.backlash.sensor.trend import JointHistory

BEFORE = ("amplitude_rps", "backlash_rad", "interval_rad", "rmse_rps", "verdict")
AFTER = (
    "amplitude_interval_rps", "period_s", "period_source", "delay_s", "mean_rps", "explained", "p_value",
    "calibration", "notes",
)  # fmt: skip
"""The keys of an estimate in JSON before and after its variables."""


def json_objects(outcomes: Iterable[Outcome], joints: Iterable[JointHistory]) -> list[JsonObject]:
    """Return outcomes, and what is known of their joints, as JSON objects; unknown values are null."""
    places = {id(one): (joint, at) for joint in joints for one, at in zip(joint.outcomes, joint.series.at, strict=True)}
    return [_failure(one) if isinstance(one, Failed) else _finite(_content(one, *places[id(one)])) for one in outcomes]


def _failure(outcome: Failed) -> JsonObject:
    joint = {"joint": outcome.joint} if outcome.joint else {}
    return {"file": str(outcome.path), **joint, "error": outcome.error}


def _content(outcome: Estimated, joint: JointHistory, at: float) -> JsonObject:
    estimate, fit = outcome.estimate, outcome.estimate.fit
    known = vars(estimate) | vars(fit) | {"mean_rps": fit.problem.mean_rps}
    return {
        "file": str(outcome.path),
        "joint": joint.series.name,
        "date": _date(joint, at),
        **{name: known[name] for name in BEFORE},
        **fit.variables,
        **{name: known[name] for name in AFTER},
        "trend": _trend(joint),
        "limit": _limit(joint),
    }


def _trend(joint: JointHistory) -> JsonObject | None:
    """Return the slope of a joint's half-gap (rad) or amplitude (rps) a month, recording, or number in the names."""
    if joint.trend is None or (line := joint.trend.line) is None:
        return None
    return {
        "quantity": {"backlash": "backlash_rad", "amplitude": "amplitude_rps"}[joint.trend.quantity],
        "per": joint.series.unit,
        "slope": line.slope,
        "interval": line.interval,
        "p_value": line.p_value,
        "significant": joint.trend.significant,
    }


def _limit(joint: JointHistory) -> JsonObject:
    """Return when a joint reaches the limit; see :attr:`problems.backlash.sensor.trend.JointHistory.outlook`."""
    status, when, ends = joint.outlook
    return {"status": status, "date": _date(joint, when), "interval": [_date(joint, end) for end in ends]}


def _date(joint: JointHistory, at: float) -> str | None:
    return joint.series.label(at) if joint.series.unit == "month" and math.isfinite(at) else None


def csv_rows(outcomes: Iterable[Outcome], joints: Iterable[JointHistory]) -> list[JsonObject]:
    """Return a row for each outcome with the keys of :func:`json_objects`: trend, limit and intervals as columns.

    Notes are joined.
    """
    rows = []
    for content in json_objects(outcomes, joints):
        row: JsonObject = {}
        for part in ("trend", "limit"):
            content |= {f"{part}_{key}": value for key, value in (content.pop(part, None) or {}).items()}
        for key, value in content.items():
            if key == "notes":
                row[key] = "; ".join(value)
            elif isinstance(value, list):
                row |= {f"{key}_low": value[0], f"{key}_high": value[1]}
            else:
                row[key] = value
        rows.append(row)
    return rows


def _finite(value: Json) -> Json:
    """Return a value with null for every number that is not finite, as JSON has none."""
    if isinstance(value, dict):
        return {key: _finite(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
