"""Plot estimates: the fit of one recording, and the backlash of joints over time."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, Locator, MaxNLocator, MultipleLocator

from bench.helpers import file_name, replacing, unique
from bench.helpers.errors import BenchError
from bench.plots import style
from problems.backlash.joint.writing import check_folder
from problems.backlash.sensor.batch import Estimated
from problems.backlash.sensor.estimate import FittedRecording, Settings
from problems.backlash.sensor.formatting import BY, UNIT
from problems.backlash.sensor.trend import Trend
from problems.backlash.signature.model import VARIABLES, oscillation

LEFT_OUT = {".svg": "Date", ".png": "Software", ".pdf": "CreationDate"}
"""By kind of picture, the metadata that is left out, so that the same estimate gives the same file."""

SIGNAL, FIT = "#9A9A9A", style.REFERENCE
MONTHS = (1, 2, 3, 6, 12, 24, 60)  # between the ticks of a time
FEW_MONTHS = 3
ASIDE = 0.05  # s, shown before and after a single oscillation


def check_output(path: Path) -> None:
    """Raise BenchError for a file that is no picture, or whose folder is missing."""
    if path.is_dir():
        return
    if not path.suffix and path.exists():
        raise BenchError(f"{path} is a file without a picture's ending; give a folder, or a .svg, .png or .pdf file")
    if path.suffix and path.suffix.lower() not in LEFT_OUT:
        raise BenchError(f"{path} must end in {', '.join(LEFT_OUT)}, or be a folder")
    check_folder(path)


def save_figures(
    path: Path, outcomes: Sequence[Estimated], trends: Sequence[Trend], settings: Settings, *, alone: bool
) -> list[Path]:
    """Draw estimates and return the pictures' paths: all of them as svg into a folder, or one into a file.

    A file gets the fit of a recording that the user gave ``alone``, else the trends of the joints.

    Raises:
        BenchError: where they cannot be written.
    """
    one = bool(path.suffix) and not path.is_dir()
    pictures = []

    def save(figure: Figure, name: str) -> None:
        picture = path if one else path / f"{name}.svg"
        with replacing(picture) as temporary:
            temporary.parent.mkdir(parents=True, exist_ok=True)
            figure.savefig(temporary, metadata={LEFT_OUT[picture.suffix.lower()]: None})
        pictures.append(picture)

    with style.context():
        names = unique(file_name(outcome.path.stem) for outcome in outcomes)
        for name, outcome in zip(names, outcomes, strict=True) if alone or not one else ():
            save(fit_figure(outcome.estimate.fit), name)
        if trends:
            save(trend_figure(trends, limit_rad=settings.limit_rad), "trend")
    return pictures


def fit_figure(fit: FittedRecording) -> Figure:
    """Plot the fit of a recording: speed and fit; the mean half turn, or the oscillation, larger; the residual."""
    figure = Figure(figsize=(style.PAGE, 5.6), layout="constrained")
    above, middle, below = figure.subplots(3, height_ratios=(2.0, 2.4, 1.0))
    recording, time = fit.recording, fit.recording.time
    dense = len(time) > style.MANY_POINTS  # kept as an image then
    above.plot(time, recording.speed, color=SIGNAL, linewidth=0.5, label="recording", rasterized=dense)
    above.plot(time, fit.fitted, color=FIT, linewidth=0.8, label="fit", rasterized=dense)
    above.set(xlabel="time in s", ylabel="motor speed in rps")
    (_draw_oscillation if fit.problem.replicas == 1 else _draw_half_turn)(middle, fit)
    below.plot(time, recording.speed - fit.fitted, color=SIGNAL, linewidth=0.5, rasterized=dense)
    below.axhline(0.0, color=FIT, linewidth=0.8)
    below.set(xlabel="time in s", ylabel="residual in rps")
    for ax in (above, below):
        ax.set_xlim(time[0], time[-1])
        ax.margins(y=0.08)
    _legend(figure)
    figure.align_ylabels()
    return figure


def trend_figure(trends: Sequence[Trend], *, limit_rad: float) -> Figure:
    """Plot the half-gaps of each joint with intervals, trend and limit, a panel for each kind of time and quantity."""
    kinds: dict[tuple[str, str], list[Trend]] = {}
    for trend in trends:
        kinds.setdefault((trend.quantity, trend.series.unit), []).append(trend)
    figure = Figure(figsize=(style.PAGE, 0.3 + 2.9 * len(kinds)), layout="constrained")
    pens = style.pens(trend.series.name for trend in trends)
    names = style.names(pens)
    for ax, ((quantity, unit), alike) in zip(np.ravel(figure.subplots(len(kinds))), kinds.items(), strict=True):
        factor, shown = UNIT[quantity]
        for trend in alike:
            _draw_trend(ax, trend, factor, pens[trend.series.name], names[trend.series.name] or "estimate")
        if any(trend.significant for trend in alike):
            ax.plot([], [], color="black", linewidth=0.9, linestyle="--", label="trend")
        if quantity == "backlash":
            ax.axhline(factor * limit_rad, color=style.REFERENCE, linewidth=1.0, linestyle=":", label="limit")
        what = "half-gap δ" if quantity == "backlash" else "amplitude A"
        ax.set(xlabel=BY[unit], ylabel=f"{what} in {shown}")
        ax.xaxis.set_major_locator(_locator(alike))
        ax.xaxis.set_major_formatter(FuncFormatter(lambda at, _, series=alike[0].series: series.label(at)))
        ax.set_ylim(bottom=0.0)
    _legend(figure)
    return figure


def _draw_half_turn(ax: Axes, fit: FittedRecording) -> None:
    """Draw all half turns over one another, every second one inverted, their mean and the fit's oscillation."""
    x = np.array([fit.variables[name] for name in VARIABLES])
    turn, delay, dt = fit.period_s, fit.delay_s, fit.recording.dt
    half = max(delay, turn - delay)
    since = (fit.recording.time - fit.variables["t0"]) % turn
    second = since >= delay
    sign = math.copysign(1.0, fit.variables["A"]) * np.where(second, -1.0, 1.0)
    phase = since - delay * second
    folded = sign * (fit.recording.speed - fit.problem.mean_rps - fit.variables["v_t"])
    ax.plot(
        phase, folded, ".", color=SIGNAL, markersize=1.5, rasterized=len(phase) > style.MANY_POINTS,
        label="its half turns over one another",
    )  # fmt: skip
    bins = np.minimum((phase / dt).astype(int), max(round(half / dt) - 1, 0))
    count = np.maximum(np.bincount(bins), 1)
    ax.plot(
        np.bincount(bins, phase) / count, np.bincount(bins, folded) / count, color="black", linewidth=0.9,
        label="their mean",
    )  # fmt: skip
    fine = np.linspace(0.0, half, 1001)[1:-1]
    wave = oscillation(fine, x) - oscillation(fine + turn - half, x)  # the one before may last into this half turn
    ax.plot(fine, math.copysign(1.0, fit.variables["A"]) * wave, color=FIT, linewidth=1.0)
    title = "time in s since the half turn's beginning; every second half turn inverted"
    ax.set(xlim=(0.0, half), xlabel=title, ylabel="disturbance in rps")


def _draw_oscillation(ax: Axes, fit: FittedRecording) -> None:
    """Draw the samples about the one oscillation, and the fit between them."""
    x = np.array([fit.variables[name] for name in VARIABLES])
    t0, end = fit.variables["t0"], fit.variables["t0"] + fit.variables["T2"]
    time = fit.recording.time
    near = (time >= t0 - ASIDE) & (time <= end + ASIDE)
    base = fit.problem.mean_rps + fit.variables["v_t"]
    ax.plot(time[near], fit.recording.speed[near] - base, ".-", color=SIGNAL, markersize=2.5, linewidth=0.5)
    fine = np.linspace(t0 - ASIDE, end + ASIDE, 1001)
    ax.plot(fine, oscillation(fine - t0, x), color=FIT, linewidth=1.0)
    ax.set(xlim=(fine[0], fine[-1]), xlabel="time in s", ylabel="disturbance in rps")


def _draw_trend(ax: Axes, trend: Trend, factor: float, pen: style.Pen, name: str) -> None:
    at, values = trend.series.at, factor * trend.values
    ax.vlines(at, *(factor * trend.intervals.T), color=pen.color, linewidth=0.8)
    ax.plot(at, values, color=pen.color, marker=pen.marker, markersize=3.5, linestyle="none", label=name)
    if trend.line is not None and trend.significant:
        ends = np.array([at[0], at[-1]])
        ax.plot(ends, factor * trend.line.at(ends), color=pen.color, linewidth=0.9, linestyle="--")


def _locator(trends: Sequence[Trend]) -> Locator:
    """Return ticks at whole months that divide years, or at round numbers; between months where there are few."""
    span = np.ptp(np.concatenate([trend.series.at for trend in trends]))
    if trends[0].series.unit != "month" or span < FEW_MONTHS:
        return MaxNLocator(8, integer=trends[0].series.unit != "month")
    return MultipleLocator(next((months for months in MONTHS if span <= 8 * months), MONTHS[-1]))


def _legend(figure: Figure) -> None:
    """Put a legend with one entry a label above all panels, unless it has too many entries to help."""
    entries: dict[str, Artist] = {}
    for ax in figure.axes:
        handles, labels = ax.get_legend_handles_labels()
        entries |= dict(zip(labels, handles, strict=True))
    if len(entries) <= style.MANY_NAMES:
        figure.legend(entries.values(), entries.keys(), loc="outside upper left", ncols=5)
