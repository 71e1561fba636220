"""A page on many recordings: verdicts, the trend of each joint, and the fit of each recording."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from bench.report import Figure, Section, Table, count, write_page
from problems.backlash.sensor.batch import Estimated, Failed
from problems.backlash.sensor.estimate import Settings
from problems.backlash.sensor.formatting import calibration_of, csv_rows, notes, trend_lines
from problems.backlash.sensor.plots import fit_figure, trend_figure
from problems.backlash.sensor.trend import Trend

COLUMNS = {
    "name": "recording", "verdict": "verdict", "backlash_rad": "half-gap, mrad", "interval_rad_low": "from",
    "interval_rad_high": "to", "amplitude_rps": "amplitude, rps", "rmse_rps": "RMSE, rps",
}  # fmt: skip


def write(
    path: Path,
    outcomes: Sequence[Estimated | Failed],
    names: Sequence[str],
    trends: Sequence[Trend],
    settings: Settings,
) -> Path:
    """Write the page of these recordings, under their names, and return its path.

    Raises:
        BenchError: where it cannot be written.
    """
    good = [(name, outcome) for name, outcome in zip(names, outcomes, strict=True) if isinstance(outcome, Estimated)]
    failed = [(name, outcome) for name, outcome in zip(names, outcomes, strict=True) if isinstance(outcome, Failed)]
    rows = [row | {"name": name} for row, name in zip(csv_rows(outcomes), names, strict=True)]
    frame = pd.DataFrame(rows).reindex(columns=list(COLUMNS))
    frame["verdict"] = frame["verdict"].astype(object).fillna("failed")
    for column in ("backlash_rad", "interval_rad_low", "interval_rad_high"):
        frame[column] = 1e3 * frame[column].astype(float)
    table = Table(
        "verdicts", "Each recording: verdict, half-gap with its interval, amplitude and residual.",
        frame.rename(columns=COLUMNS), decimals=3, note=f"The limit is {1e3 * settings.limit_rad:g} mrad.",
    )  # fmt: skip
    lost = tuple(outcome.error for _, outcome in failed)
    remarks = (*notes(outcomes, names), *(f"Calibration: {line}." for line in calibration_of(settings)))
    text = tuple("; ".join(line.strip() for line in trend_lines(one, settings)) + "." for one in trends)
    sections = [Section("Verdicts and trends", text, (*_trend(trends, settings), table), lost)]
    fits = tuple(Section(name, (), (_fit(name, outcome, settings),), folded=True) for name, outcome in good)
    if fits:
        sections.append(Section("Fits", ("Open a recording to see its fit and residual.",), sections=fits))
    if remarks:
        sections.append(Section("Notes", remarks))
    progressed = sum(outcome.estimate.verdict == "progressed" for _, outcome in good)
    lead = f"{count(len(outcomes), 'recording')}, {progressed} with progressed backlash, {len(failed)} not estimated."
    return write_page(path, "Backlash of joints", lead, sections)


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


def _fit(name: str, outcome: Estimated, settings: Settings) -> Figure:
    estimate = outcome.estimate
    data = pd.DataFrame([estimate.variables])
    return Figure(
        f"fit {name}", f"Recording, fit and residual of {name}.", fit_figure(estimate, single=settings.single), data
    )
