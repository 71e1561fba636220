"""What the trials fitted: a half turn of each recording with the signature of the best and of the median trial."""

from __future__ import annotations

from math import ceil
from typing import Any

import matplotlib.figure
import numpy as np
import pandas as pd

from bench import Results
from bench.analysis import labels
from bench.plots import style
from bench.report import Figure, Section, count
from bench.typing import Floats
from problems.backlash.report.accuracy import short
from problems.backlash.report.reference import signature_problems
from problems.backlash.signature.model import T0, VARIABLES, signature
from problems.backlash.signature.problem import SignatureFit

TITLE = "Recorded signal and fitted signature"
MOST, ROWS = 8, 20  # columns and rows of a figure; more recordings get another figure
POINTS = 100  # of a curve
SIGNAL, BEST, MEDIAN = "recording", "best trial", "median trial"
LINES: dict[str, dict[str, Any]] = {
    SIGNAL: {"color": "0.65", "linewidth": 1.8},
    BEST: {"color": style.PALETTE[0], "linewidth": 0.8},
    MEDIAN: {"color": style.PALETTE[4], "linewidth": 0.8, "linestyle": (0, (3, 1))},
}
RIGHT, TOP, BOTTOM, ROW = 0.5, 0.45, 0.08, 0.36  # inches
GAP = 0.08  # between panels, as a share of one
OVER = 1.15  # a curve may leave the range of the recording by this factor


def sections(results: Results, frame: pd.DataFrame) -> list[Section]:
    """Return the section on the fits, none where no signature problem can be loaded or no trial finished."""
    frame = frame[frame["status"] == "ok"]
    problems = signature_problems(results, frame)
    shown = shown_trials(frame[frame["problem"].isin(problems)])
    if shown.empty:
        return []
    every = labels(frame, "optimizer")
    optimizers = leading(shown, every)
    names = list(dict.fromkeys(shown["problem"]))
    figures = []
    for number, start in enumerate(range(0, len(names), ROWS), start=1):
        part = {label: problems[label] for label in names[start : start + ROWS]}
        trials = shown[shown["problem"].isin(part) & shown["optimizer"].isin(optimizers)]
        figures.append(_figure(curves(trials, part), trials, optimizers, len(every), number))
    text = (
        "The signature is fitted to the whole recording; shown is one half turn from its middle, in which the best fit "
        "of all begins at the left. The median trial shows what to expect of a single run."
    )
    return [Section(TITLE, (text,), tuple(figures))]


def shown_trials(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the best and the median trial of each cell (the lower one of two), in the frame's order of cells.

    Columns: problem, optimizer, curve (``BEST`` or ``MEDIAN``), trial, fun and the variables. A trial whose point is
    not known is left out.
    """
    names = [f"x_{name}" for name in VARIABLES]
    if not {*names} <= {*frame}:
        return pd.DataFrame(columns=["problem", "optimizer", "curve", "trial", "fun", *VARIABLES])
    complete = frame.dropna(subset=[*names, "fun"]).sort_values(["problem", "optimizer", "fun", "trial"])
    cells = complete.groupby(["problem", "optimizer"], observed=True)
    rank, size = cells.cumcount(), cells["trial"].transform("size")
    parts = [complete[rank == 0].assign(curve=BEST), complete[rank == (size - 1) // 2].assign(curve=MEDIAN)]
    chosen = pd.concat(parts).sort_values(["problem", "optimizer", "curve"])
    chosen = chosen.rename(columns=dict(zip(names, VARIABLES, strict=True)))
    return chosen[["problem", "optimizer", "curve", "trial", "fun", *VARIABLES]]


def leading(shown: pd.DataFrame, optimizers: list[str]) -> list[str]:
    """Return the optimizers to draw, at most ``MOST``: of more, those whose median trials have the lowest mean rank."""
    medians = shown[shown["curve"] == MEDIAN].pivot(index="problem", columns="optimizer", values="fun")
    present = [label for label in optimizers if label in medians]
    ranks = medians[present].rank(axis=1).mean().sort_values(kind="stable")
    chosen = {*ranks.index[:MOST]}
    return [label for label in present if label in chosen]


def curves(shown: pd.DataFrame, problems: dict[str, SignatureFit]) -> pd.DataFrame:
    """Return the recording's and the fitted speeds about the mean speed over one half turn, a row a sample.

    Columns: problem, optimizer ("" for the recording), curve, time in s, and speed in the unit of the problem.
    """
    parts = []
    for label, problem in problems.items():
        trials = shown[shown["problem"] == label]
        best = trials.sort_values("fun", kind="stable")[list(VARIABLES)].to_numpy(dtype=float)[0]
        inside = window(problem, best)
        time = problem.time[inside]
        rows = [("", SIGNAL, problem.signal[inside])]
        for row in trials.itertuples():
            x = np.array([getattr(row, name) for name in VARIABLES], dtype=float)
            fitted = signature(time, x, period=problem.period, replicas=problem.replicas)
            rows.append((str(row.optimizer), str(row.curve), fitted))
        parts += [
            pd.DataFrame({"problem": label, "optimizer": name, "curve": curve, "time": time, "speed": speed})
            for name, curve, speed in rows
        ]
    return pd.concat(parts, ignore_index=True)


def window(problem: SignatureFit, x: Floats) -> slice:
    """Return which samples of the recording lie in the half turn to show: at a point (7,), one that begins near its t0.

    It is the one of the middle turn that has the sign of A; at most ``POINTS`` samples of it are taken.
    """
    time, turn = problem.time, problem.period
    start = float(x[T0])
    if problem.replicas > 1:
        start += turn * round(((time[0] + time[-1]) / 2 - start) / turn)
    first = int(np.searchsorted(time, start - problem.dt / 2))
    number = max(round(turn / 2 / problem.dt), 2)
    first = max(min(first, len(time) - number), 0)
    return slice(first, first + number, ceil(number / POINTS))


def _figure(data: pd.DataFrame, shown: pd.DataFrame, optimizers: list[str], every: int, number: int) -> Figure:
    best = shown[shown["curve"] == BEST].pivot(index="problem", columns="optimizer", values="fun")
    chosen = (
        f" Of {count(every, 'optimizer')}, those {len(optimizers)} whose median trials rank lowest on average."
        if len(optimizers) < every
        else ""
    )
    caption = (
        "Motor speed about its mean over a half turn, by recording (rows; right: the half range in the unit of its "
        f"RMSE) and optimizer (columns), with the fitted signature of the best and of the median trial.{chosen}"
    )
    abridged = best.reindex(columns=optimizers).rename_axis(columns=None).add_prefix("RMSE of best: ")
    return Figure("fits" if number == 1 else f"fits-{number}", caption, _drawn(data, optimizers), data, abridged)


def _drawn(data: pd.DataFrame, optimizers: list[str]) -> matplotlib.figure.Figure:
    """Draw all panels on one Axes, rows of recordings and columns of optimizers: ninety Axes would take seconds."""
    problems = list(dict.fromkeys(data["problem"]))
    height = TOP + ROW * len(problems) + BOTTOM
    names = [style.plain(short(problem), 18) for problem in problems]
    left = style.text_width(names, style.SMALL) + 0.1
    drawn = matplotlib.figure.Figure(figsize=(style.TEXT, height))
    ax = drawn.add_axes(
        (left / style.TEXT, BOTTOM / height, 1 - (left + RIGHT) / style.TEXT, ROW * len(problems) / height)
    )
    ax.set_axis_off()
    ax.set(xlim=(0, len(optimizers)), ylim=(len(problems), 0))
    lines: dict[str, list[Floats]] = {curve: [] for curve in LINES}
    for row, (_, rows) in enumerate(data.groupby("problem", sort=False)):
        signal = rows.loc[rows["curve"] == SIGNAL, "speed"].to_numpy()
        time = rows.loc[rows["curve"] == SIGNAL, "time"].to_numpy()
        middle, reach = (signal.max() + signal.min()) / 2, max((signal.max() - signal.min()) / 2, 1e-12)
        at = GAP / 2 + (1 - GAP) * (time - time[0]) / (time[-1] - time[0])
        present = rows.groupby(["optimizer", "curve"], sort=False)["speed"]
        speeds = {(str(name), str(curve)): speed.to_numpy() for (name, curve), speed in present}
        for column, optimizer in enumerate(optimizers):
            for curve, drawn_lines in lines.items():
                speed = signal if curve == SIGNAL else speeds.get((optimizer, curve))
                if speed is not None:
                    scaled = np.clip((speed - middle) / reach, -OVER, OVER) / OVER
                    drawn_lines.append(np.column_stack([column + at, row + 0.5 - (1 - GAP) / 2 * scaled]))
        ax.text(-0.03, row + 0.5, names[row], ha="right", va="center", fontsize="small")
        ax.text(len(optimizers) + 0.02, row + 0.5, f"±{reach:.3g}", va="center", fontsize="small")
    for column, name in enumerate(style.names(optimizers, 160 // (7 + len(optimizers))).values()):
        ax.text(column + 0.5, -0.12, name, ha="center", va="bottom")
    gap = np.full((1, 2), np.nan)
    handles = []
    for curve, parts in lines.items():
        points = np.concatenate([line for part in parts for line in (part, gap)])
        handles += ax.plot(points[:, 0], points[:, 1], label=curve, clip_on=False, **LINES[curve])
    style.legend_above(drawn, handles)
    return drawn
