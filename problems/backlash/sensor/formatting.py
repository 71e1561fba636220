"""Format estimates, trends and calibrations: as lines for a maintenance engineer, and as a table."""

import math
from collections.abc import Iterable, Sequence
from textwrap import wrap

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from bench.helpers import print_line
from problems.backlash.sensor.batch import Estimated, Failed
from problems.backlash.sensor.estimate import CONFIDENCE, Estimate, Settings
from problems.backlash.sensor.recording_files import Series
from problems.backlash.sensor.trend import HORIZON, Trend
from problems.backlash.signature.calibration import EQUATION_4_7, Calibration, sensor_calibration

ARC_MINUTES = 60 * 180 / math.pi  # in a rad
UNIT = {
    "backlash": (1e3, "mrad"),
    "amplitude": (1.0, "rps"),
}  # by quantity, factor for display and unit then
PER = {"month": "a month", "number": "for each 1 of the number in the names", "file": "a recording"}
BY = {"month": "month", "number": "number in the file's name", "file": "recording"}
WORD = {"month": "", "number": "number ", "file": "recording "}
SOURCE = {
    "gear ratio": "from the gear ratio", "calibration": "from the calibration's gear ratio",
    "signal": "found in the signal",
}  # fmt: skip
SHOWN = 5  # files named with a note at most
NARROWEST = 40  # columns of a terminal to which lines are broken at least
WIDTH = 160  # columns of a table that is not printed on a terminal
NARROW = 110  # columns of a terminal below which a table leaves out what it can
SHORT, LONG = 22, 50  # letters of a file's name in a narrow table and in a wide one
STYLES = {"progressed": "bold red", "early": "yellow", "undecided": "yellow", "no backlash": "green"}


def is_alarm(estimate: Estimate, least: str) -> bool:
    """Return whether a verdict is "progressed", or, where ``least`` is "early", any on a disturbance that is detected.

    What is undecided as the noise may hide it is no alarm.
    """
    if least == "progressed" or estimate.verdict in ("progressed", "no backlash"):
        return estimate.verdict == "progressed"
    return estimate.amplitude_rps > 0.0


def estimate_lines(outcome: Estimated, settings: Settings, width: int | None = None) -> list[str]:
    """Return the lines on one estimate, with its verdict first; with a ``width``, longer lines are broken."""
    estimate, fit = outcome.estimate, outcome.estimate.fit
    rows = _amount(estimate, settings) if estimate.amplitude_rps else _hidden(estimate, settings)
    chance = f"p = {estimate.p_value:.1g}" if estimate.p_value >= 1e-6 else "p < 1e-6"
    explained = f"explains {fit.explained:.1%} of the signal's variance ({chance} for noise alone)"
    turn = f"{fit.period_s:.6g} s ({SOURCE.get(fit.period_source, fit.period_source)})"
    length = f"{fit.recording.duration:.4g} s, {fit.recording.duration / fit.period_s:.4g} load turns"
    rows += [
        ("fit", f"RMSE {fit.rmse_rps:.4f} rps; {explained}"),
        ("load turn", f"{turn}; {length}, {len(fit.recording.speed)} samples at {fit.problem.mean_rps:.4g} rps"),
    ]
    if estimate.calibration:
        rows += zip(("calibration", "", ""), calibration_of(settings), strict=False)
    rows += [("note", note) for note in estimate.notes[: -1 if estimate.verdict == "undecided" else None]]
    column = max(len(name) for name, _ in rows)
    lines = [f"{outcome.path}: {_verdict(estimate, settings)}", *(f"  {name:{column}}  {text}" for name, text in rows)]
    return lines if width is None else [part for line in lines for part in broken(line, width, column + 4)]


def broken(line: str, width: int, indent: int = 4) -> list[str]:
    """Return the parts of a line broken between words at a terminal's width, all but the first one indented."""
    narrow = max(width, NARROWEST)
    return wrap(line, narrow, subsequent_indent=" " * indent, break_long_words=False, break_on_hyphens=False)


def print_table(
    outcomes: Sequence[Estimated | Failed], names: Sequence[str], trends: Iterable[Trend], settings: Settings
) -> None:
    """Print a row for each file, every note once, and the trends."""
    console = Console(width=None if Console().is_terminal else WIDTH)
    console.print(table(outcomes, names, console.width), highlight=False)
    calibrated = any(isinstance(outcome, Estimated) and outcome.estimate.calibration for outcome in outcomes)
    calibration = [f"calibration: {line}" for line in calibration_of(settings)] if calibrated else []
    for line in [
        *notes(outcomes, names),
        *calibration,
        *(line for trend in trends for line in trend_lines(trend, settings)),
    ]:
        print_line("\n".join(broken(line, console.width)) if console.is_terminal else line)


def table(outcomes: Sequence[Estimated | Failed], names: Sequence[str], width: int = WIDTH) -> Table:
    """Return a row for each file under its name: verdict, half-gap and amplitude with their intervals, RMSE.

    A long name is shortened in the middle. A table of fewer columns of letters than ``NARROW`` has neither the interval
    of the amplitude nor the RMSE.
    """
    narrow = width < NARROW
    made = Table(box=None, pad_edge=False)
    made.add_column("verdict", no_wrap=True)
    made.add_column("file", no_wrap=True)
    heads = ("half-gap,\nmrad", "interval", "amplitude,\nrps", "interval", "RMSE,\nrps")
    shown = heads[:-2] if narrow else heads
    for heading in shown:
        made.add_column(heading, justify="right", no_wrap=True)
    for name, outcome in zip(names, outcomes, strict=True):
        short = Text(shortened(name, SHORT if narrow else LONG))
        if isinstance(outcome, Failed):
            made.add_row(Text("failed", style="red"), short)
            continue
        estimate = outcome.estimate
        numbers = (
            "" if math.isnan(estimate.backlash_rad) else f"{1e3 * estimate.backlash_rad:.3f}",
            _range(estimate.interval_rad, ".3f", 1e3),
            f"{estimate.amplitude_rps:.4f}",
            _range(estimate.amplitude_interval_rps, ".4f"),
            f"{estimate.fit.rmse_rps:.4f}",
        )
        verdict = Text(estimate.verdict, style=STYLES.get(estimate.verdict, ""))
        made.add_row(verdict, short, *numbers[: len(shown)])
    return made


def shortened(name: str, most: int) -> str:
    """Return a name of at most ``most`` letters; a longer one has … in the middle, as ends differ."""
    return name if len(name) <= most else f"{name[: most // 3]}…{name[most // 3 + 1 - most :]}"


def notes(outcomes: Sequence[Estimated | Failed], names: Sequence[str]) -> list[str]:
    """Return every note once, with the files it concerns."""
    of: dict[str, list[str]] = {}
    for name, outcome in zip(names, outcomes, strict=True):
        for note in outcome.estimate.notes if isinstance(outcome, Estimated) else ():
            of.setdefault(note, []).append(name)
    lines = []
    for note, files in of.items():
        more = f" and {len(files) - SHOWN} more" if len(files) > SHOWN else ""
        lines.append(f"note on {', '.join(files[:SHOWN])}{more}: {note}")
    return lines


def trend_lines(trend: Trend, settings: Settings) -> list[str]:
    """Return the lines on how the backlash of a joint has changed, and when it reaches the limit."""
    series, (factor, unit) = trend.series, UNIT[trend.quantity]
    first, last = _when(series, series.at[0]), _when(series, series.at[-1])
    what = "half-gap" if trend.quantity == "backlash" else "amplitude (not all have a half-gap)"
    lines = [
        f"{series.name or 'trend'}: {what} {factor * trend.values[0]:.3f} {unit} in {first}, "
        f"{factor * trend.values[-1]:.3f} in {last}: a change of {factor * trend.change:+.3f}"
        + (f" ({change})" if (change := _range(trend.change_interval, "+.3f", factor)) else "")
    ]
    if trend.line is None:
        return [*lines, "  a slope needs three recordings of different times"]
    slope, per = factor * trend.line.slope, f"{unit} {PER[series.unit]}"
    low, high = (factor * end for end in trend.line.interval)
    chance = f"p = {trend.line.p_value:.2g}" if trend.line.p_value >= 1e-3 else "p < 0.001"
    if trend.significant:
        lines.append(
            f"  it {'grows' if slope > 0 else 'falls'} by {abs(slope):.3g} {per} "
            f"({CONFIDENCE:.0%} interval {min(abs(low), abs(high)):.3g} to "
            f"{max(abs(low), abs(high)):.3g}, {chance})"
        )
    else:
        lines.append(f"  no trend: {slope:+.3g} {per} ({low:+.3g} to {high:+.3g}) may be chance ({chance})")
    if trend.quantity == "backlash":
        lines.append(f"  the limit of {1e3 * settings.limit_rad:g} mrad {_limit(trend)}")
    return lines


def calibration_lines(made: Calibration, *, is_default: bool) -> list[str]:
    """Return the lines on a calibration's pairs, its range, and for the default joint its difference from eq. 4.7."""
    columns = {"amplitude in rps": made.amplitude / 60, "half-gap in rad": made.half_gap}
    if made.fitted is not None and made.scatter is not None:
        columns |= {"fit in rps": made.fitted / 60, "its scatter": made.scatter / 60}
    formats = [f"{len(title)}.6f" for title in columns]
    rows = zip(*columns.values(), strict=True)
    lines = [made.name, "   ".join(columns), *("   ".join(map(format, row, formats)) for row in rows)]
    low, high = (amplitude / 60 for amplitude in made.range)
    lines.append(f"range: {low:.4g} to {high:.4g} rps; no backlash is estimated outside")
    if is_default and math.isfinite(made.deviation):
        lines.append(f"difference from eq. 4.7 of the thesis: at most {made.deviation:.3%}")
        if len(made.amplitude) > len(EQUATION_4_7):  # else it is determined by the pairs, or not at all
            lines.append(f"least-squares cubic, as eq. 4.7: {made.formula()}")
    return lines


def _amount(estimate: Estimate, settings: Settings) -> list[tuple[str, str]]:
    """Return the rows on the size of a disturbance and of the gap that causes it."""
    percent = f"{CONFIDENCE:.0%}"
    span = _span(estimate.amplitude_interval_rps, ".4f", percent)
    rows = [("amplitude", f"{estimate.amplitude_rps:.4f} rps of the motor{span}")]
    if math.isnan(estimate.backlash_rad):
        why = "the amplitude is outside the calibration" if estimate.calibration else "needs a calibration"
        if estimate.verdict == "undecided":
            why = "see the verdict"
        elif settings.calibration and not estimate.calibration:
            why = "the calibration is of another joint or speed"
        return [*rows, ("half-gap", f"not estimated: {why}")]
    gap, ends = estimate.backlash_rad, estimate.interval_rad
    held = f"{spelled} if the joint is as calibrated" if (spelled := _span(ends, ".3f", percent, 1e3)) else ""
    return [
        *rows,
        ("half-gap", f"{1e3 * gap:.3f} mrad at the joint{held}"),
        ("", f"{gap * ARC_MINUTES:.2f} arc minutes{_span(ends, '.2f', percent, ARC_MINUTES)}"),
        ("total gap", f"twice the half-gap: {2e3 * gap:.3f} mrad, {2 * gap * ARC_MINUTES:.2f} arc minutes"),
    ]


def calibration_of(settings: Settings) -> list[str]:
    """Return the name of a calibration, and which joint half-gaps and verdicts by it hold for."""
    made = settings.calibration
    if made is None:
        return []
    joint = [f"gear ratio {made.gear_ratio:g}"] if made.gear_ratio is not None else []
    joint += [f"motor at {made.speed_rps:g} rps"] if made.speed_rps is not None else []
    lines = ["; ".join((made.name, *joint))]
    if len(joint) < 2:
        lines.append("it states no gear ratio or no motor speed, which the recording was not compared with")
    if made is sensor_calibration():
        lines.append(
            "half-gap and verdict hold for the thesis's simulated joint; for another joint make its own by "
            "'bench calibrate --joint'"
        )
    return lines


def _hidden(estimate: Estimate, settings: Settings) -> list[tuple[str, str]]:
    """Return the rows on what the noise may hide where no disturbance is detected."""
    most, gap, calibration = (
        estimate.amplitude_interval_rps[1],
        estimate.interval_rad[1],
        settings.calibration if estimate.calibration else None,
    )
    hidden = f"the noise hides any below {most:.4f} rps"
    if most > np.ptp(estimate.fit.recording.speed):
        hidden = "the recording is too short or too noisy to show one"
    rows = [("amplitude", f"none detected; {hidden}")]
    if calibration and 60 * most > calibration.range[1]:
        rows.append(("half-gap", "the noise hides any in the calibrated range"))
    elif calibration:
        gap = calibration.half_gap[0] if math.isnan(gap) else gap  # below the calibration
        arc = f"{gap * ARC_MINUTES:.2f} arc minutes"
        rows.append(("half-gap", f"the noise hides any up to {1e3 * gap:.3f} mrad ({arc})"))
    rows.append(("not seen", "a gap that never opens in this motion, as with strong viscous friction"))
    return rows


def _verdict(estimate: Estimate, settings: Settings) -> str:
    limit = f"the limit of {1e3 * settings.limit_rad:g} mrad"
    needed = "needs a calibration of this joint at this speed"
    return {
        "undecided": f"UNDECIDED: {estimate.notes[-1] if estimate.notes else 'the data allow no verdict'}",
        "no backlash": "no backlash detected" + ("" if estimate.calibration else f"; what the noise may hide {needed}"),
        "early": f"early backlash, up to {limit}",
        "progressed": f"PROGRESSED BACKLASH, above {limit}",
        "backlash": f"backlash detected; its size {needed}",
    }[estimate.verdict]


def _limit(trend: Trend) -> str:
    """Return the end of the sentence on when the limit is reached."""
    status, when, (early, late) = trend.outlook
    series, latest = trend.series, f"the latest {trend.latest} recordings"
    if status == "passed":
        return f"has been passed in {_when(series, when)}"
    if status in ("no growth", "unknown"):
        return f"is not predicted to be reached: {latest} show no significant growth"
    if status == "distant":
        return f"is not reached within {HORIZON / 12:g} years if the growth of {latest} continues"
    until = f"to {series.label(late)}" if math.isfinite(late) else "or never"
    return f"is reached in {_when(series, when)} ({series.label(early)} {until}) if the growth of {latest} continues"


def _when(series: Series, at: float) -> str:
    return WORD[series.unit] + series.label(at)


def _range(ends: Iterable[float], digits: str, factor: float = 1.0) -> str:
    """Return an interval times a factor, with … for an end outside the calibration; "" without an interval."""
    low, high = ("…" if math.isnan(end) else f"{factor * end:{digits}}" for end in ends)
    return f"{low} to {high}" if (low, high) != ("…", "…") else ""


def _span(ends: Iterable[float], digits: str, percent: str, factor: float = 1.0) -> str:
    spelled = _range(ends, digits, factor)
    return f", {percent} interval {spelled}" if spelled else ""
