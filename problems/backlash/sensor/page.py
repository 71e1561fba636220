"""A page on many recordings: a row for each joint, then verdicts and trends, and the fit of each recording."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from bench.report import Figure, Line, Section, Table, Typography, count, write_page
from problems.backlash.sensor.batch import Estimated, Failed
from problems.backlash.sensor.estimate import CONFIDENCE, FittedRecording, Settings
from problems.backlash.sensor.formatting import PER, calibration_of, notes, trend_lines
from problems.backlash.sensor.plots import fit_figure, trend_figure
from problems.backlash.sensor.records import csv_rows
from problems.backlash.sensor.trend import HORIZON, JointHistory, Trend

TONES = {"no backlash": "good", "progressed": "bad"}  # of a verdict; any other one is for a person to look at
COLUMNS = {
    "name": "recording", "verdict": "verdict", "backlash_rad": "half-gap, mrad", "interval_rad_low": "from",
    "interval_rad_high": "to", "amplitude_rps": "amplitude, rps", "rmse_rps": "RMSE, rps",
}  # fmt: skip


def write(
    path: Path,
    outcomes: Sequence[Estimated | Failed],
    names: Sequence[str],
    joints: Sequence[JointHistory],
    settings: Settings,
) -> Path:
    """Write the page of these recordings, under their names, and return its path.

    Raises:
        BenchError: where it cannot be written.
    """
    good = [(name, outcome) for name, outcome in zip(names, outcomes, strict=True) if isinstance(outcome, Estimated)]
    failed = [(name, outcome) for name, outcome in zip(names, outcomes, strict=True) if isinstance(outcome, Failed)]
    rows = [row | {"name": name} for row, name in zip(csv_rows(outcomes, joints), names, strict=True)]
    frame = pd.DataFrame(rows).reindex(columns=list(COLUMNS))
    frame["verdict"] = frame["verdict"].astype(object).fillna("failed")
    for column in ("backlash_rad", "interval_rad_low", "interval_rad_high"):
        frame[column] = 1e3 * frame[column].astype(float)
    table = Table(
        "verdicts", "Each recording: verdict, half-gap with its interval, amplitude and residual.",
        frame.rename(columns=COLUMNS), decimals=3, note=f"The limit is {1e3 * settings.limit_rad:g} mrad.",
    )  # fmt: skip
    lost = tuple(Line(name, outcome.error) for name, outcome in failed)
    remarks = (*notes(outcomes, names), *(f"Calibration: {line}." for line in calibration_of(settings)))
    trends = [joint.trend for joint in joints if joint.trend]
    text = tuple("; ".join(line.strip() for line in trend_lines(one, settings)) + "." for one in trends)
    sections = [
        Section("Joints", items=(_joints(joints, settings),) if joints else (), lines=lost),
        Section("Verdicts and trends", text, (*_trend(trends, settings), table)),
    ]
    fits = tuple(Section(name, (), (_fit(name, outcome.estimate.fit),), folded=True) for name, outcome in good)
    if fits:
        sections.append(Section("Fits", ("Open a recording to see its fit and residual.",), sections=fits))
    if remarks:
        sections.append(Section("Notes", remarks))
    progressed = sum(joint.latest.verdict == "progressed" for joint in joints)
    lead = (
        f"{count(len(joints), 'joint')}, {progressed} with progressed backlash at last; "
        f"{count(len(outcomes), 'recording')}, {len(failed)} not estimated."
    )
    return write_page(path, "Backlash of joints", lead, sections)


def _joints(joints: Sequence[JointHistory], settings: Settings) -> Table:
    """Return a row for each joint: what to know first of it."""
    name = [joint.series.name or "joint" for joint in joints]
    frame = pd.DataFrame(
        {
            "latest verdict": [joint.latest.verdict for joint in joints],
            "half-gap, mrad": [_half_gap(joint) for joint in joints],
            "change, mrad": [_change(joint) for joint in joints],
            "limit reached": [_reached(joint) for joint in joints],
            "latest recording": [joint.series.label(joint.series.at[-1]) for joint in joints],
        },
        index=pd.Index(name, name="joint"),
    )
    tones = pd.DataFrame({"latest verdict": [TONES.get(verdict, "warn") for verdict in frame["latest verdict"]]})
    caption = f"Each joint at its latest recording, with {CONFIDENCE:.0%} intervals."
    note = (
        f"The limit is a half-gap of {1e3 * settings.limit_rad:g} mrad. Its date assumes that the growth of the later "
        "half of the recordings continues."
    )
    return Table("joints", caption, frame, Typography(tones=tones.set_axis(frame.index)), note=note)


def _half_gap(joint: JointHistory) -> str:
    gap, (low, high) = joint.latest.backlash_rad, joint.latest.interval_rad
    if np.isnan(gap):
        return "unknown"
    return f"{1e3 * gap:.2f}" + (f" ({1e3 * low:.2f} to {1e3 * high:.2f})" if np.isfinite([low, high]).all() else "")


def _change(joint: JointHistory) -> str:
    """Return the slope of a joint's half-gap with its interval, or why there is none."""
    if joint.trend is None or joint.trend.line is None:
        return "unknown: fewer than three recordings"
    if joint.trend.quantity != "backlash":
        return "unknown: not every half-gap is known"
    line, per = joint.trend.line, PER[joint.series.unit]
    low, high = (1e3 * end for end in line.interval)
    slope = f"{1e3 * line.slope:+.3f} {per} ({low:+.3f} to {high:+.3f})"
    return slope if joint.trend.significant else f"no trend: {slope}"


def _reached(joint: JointHistory) -> str:
    """Return when a joint reaches the limit, or why that is not known."""
    status, when, (early, late) = joint.outlook
    label = joint.series.label
    if status == "predicted":
        return f"{label(when)} ({label(early)} {f'to {label(late)}' if np.isfinite(late) else 'or never'})"
    return {
        "passed": f"passed in {label(when)}" if status == "passed" else "",
        "distant": f"not within {HORIZON / 12:g} years",
        "no growth": f"unknown: no growth in the latest {joint.trend.latest if joint.trend else 0} recordings",
        "unknown": "unknown",
    }[status]


def _trend(trends: Sequence[Trend], settings: Settings) -> list[Figure]:
    if not trends:
        return []
    data = pd.concat(
        pd.DataFrame({"joint": trend.series.name, "at": trend.series.at, trend.quantity: np.asarray(trend.values)})
        for trend in trends
    )
    return [
        Figure(
            "trend", "The backlash of each joint over time, with intervals, trend and limit.",
            trend_figure(trends, limit_rad=settings.limit_rad), data,
        )
    ]  # fmt: skip


def _fit(name: str, fit: FittedRecording) -> Figure:
    data = pd.DataFrame([fit.variables])
    return Figure(f"fit {name}", f"Recording, fit and residual of {name}.", fit_figure(fit), data)
