"""Fig. 7.4: the disturbance amplitude each trial found, against the expected one and its accuracy band."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cbook import boxplot_stats

from bench import Study
from bench.analysis import labels
from bench.plots import style
from bench.report import Figure, Section, Table
from problems.backlash.report.accuracy import errors_by, estimates, expected_by_problem
from problems.backlash.report.axes import dataset_panels
from problems.backlash.report.conclusions import sentences
from problems.backlash.signature.problem import TOLERANCE_RPM

REFERENCES = ("expected amplitude", "accuracy band")
LEGEND = {"dots": ("trial", *REFERENCES), "boxes": ("median", "beyond the whiskers", *REFERENCES)}
BAND = f"±{TOLERANCE_RPM:.4f} rpm"


def sections(frame: pd.DataFrame, truths: pd.DataFrame, study: Study) -> list[Section]:
    """Return the section on amplitudes, with figures only where no expected amplitude is known."""
    title = "Disturbance amplitude (thesis Fig. 7.4)"
    data = estimates(frame, truths, "amplitude_rpm")
    if data.empty:
        return [Section(title, ("No trial found an amplitude.",))]
    errors = errors_by(data, ["problem", "optimizer"])
    figures = [figure(data, errors, form) for form in ("dots", "boxes")]
    if errors.empty:
        text = ("No expected amplitude is known for these problems, so there is no error to give.",)
        return [Section(title, text, tuple(figures))]
    return [Section(title, sentences(data, study), (*figures, *_tables(data, errors)))]


def _tables(data: pd.DataFrame, cells: pd.DataFrame) -> list[Table]:
    overall = Table(
        "amplitude-errors",
        f"Amplitude error in rpm (found less expected), and the percentage of trials within {BAND}.",
        errors_by(data, ["optimizer"]),
        decimals={"mean error": 2, "median error": 2, "within band %": 1},
        note="Errors are over finished trials, the percentage is over all; a failed trial is not within the band.",
    )
    captions = {
        "within band %": (f"percentage of trials within {BAND}", 0),
        "median error": ("median amplitude error in rpm", 2),
        "mean error": ("mean amplitude error in rpm", 2),
    }
    by_dataset = [
        Table(
            f"amplitude-{column.removesuffix(' %').replace(' ', '-')}-by-dataset",
            f"By dataset: {caption}.",
            cells[column].unstack("optimizer").rename_axis(columns=None),
            decimals=decimals,
        )
        for column, (caption, decimals) in captions.items()
    ]
    return [overall, *by_dataset]


def figure(data: pd.DataFrame, errors: pd.DataFrame, form: str) -> Figure:
    """Return Fig. 7.4 as "dots" (its upper part) or "boxes" (its lower one), a panel an optimizer."""
    problems, optimizers = labels(data, "problem"), labels(data, "optimizer")
    drawn, axes = dataset_panels(optimizers, problems, list(LEGEND[form]), columns=3, height=1.4)
    truth = expected_by_problem(data)
    found = data[data["found"].notna()]
    for ax, optimizer in zip(axes, optimizers, strict=True):
        own = found[found["optimizer"] == optimizer]
        (_dots if form == "dots" else _boxes)(ax, own["problem"].cat.codes.to_numpy(), own["found"].to_numpy())
        _expected(ax, truth)
    for ax in axes[::3]:
        ax.set_ylabel("|A| in rpm")
    handles = {str(handle.get_label()): handle for ax in axes for handle in ax.get_legend_handles_labels()[0]}
    style.legend_above(drawn, list(handles.values()))
    what = "every trial a dot" if form == "dots" else "box plots (whiskers: 1.5 times the interquartile range)"
    caption = (
        f"Disturbance amplitude found, by dataset: {what}. Line: the expected amplitude; dotted: the accuracy band of "
        f"{BAND} (thesis Fig. 7.4)."
    )
    return Figure(f"amplitude-{form}", caption, drawn, data, errors.reset_index() if len(errors) else None)


def _dots(ax: Axes, at: np.ndarray, values: np.ndarray) -> None:
    ax.plot(
        at, values, "o", color=style.PALETTE[0], markersize=2, markeredgewidth=0, alpha=0.6,
        rasterized=len(at) > style.MANY_POINTS, label=LEGEND["dots"][0],
    )  # fmt: skip


def _boxes(ax: Axes, at: np.ndarray, values: np.ndarray) -> None:
    """Draw Tukey's box plots, each kind of line at once: eighteen boxes of matplotlib or seaborn are 126 artists."""
    places = np.unique(at)
    if not len(places):
        return
    boxes = pd.DataFrame(boxplot_stats([values[at == place] for place in places]))
    ax.use_sticky_edges = False  # the end of a bar is no limit of the axis
    line: dict[str, Any] = {"color": "black", "linewidth": 0.6}
    ax.bar(places, boxes["q3"] - boxes["q1"], 0.6, boxes["q1"], facecolor="none", edgecolor="black", linewidth=0.6)
    ax.vlines(np.tile(places, 2), [*boxes["whislo"], *boxes["q3"]], [*boxes["q1"], *boxes["whishi"]], **line)
    caps = np.tile(places, 2)
    ax.hlines([*boxes["whislo"], *boxes["whishi"]], caps - 0.15, caps + 0.15, **line)
    ax.hlines(boxes["med"], places - 0.3, places + 0.3, color=style.PALETTE[0], linewidth=1.2, label=LEGEND["boxes"][0])
    beyond = boxes["fliers"]
    ax.plot(
        np.repeat(places, beyond.map(len)), np.concatenate(list(beyond)), "o", markerfacecolor="none",
        markeredgecolor="black", markersize=2, markeredgewidth=0.4, label=LEGEND["boxes"][1],
    )  # fmt: skip


def _expected(ax: Axes, truth: pd.DataFrame) -> None:
    at, expected, tolerance = np.arange(len(truth)), truth["expected"], truth["tolerance"]
    if expected.isna().all():
        return
    ax.plot(at, expected, "-", color=style.REFERENCE, linewidth=0.8, label=REFERENCES[0])
    for sign, label in ((-1, REFERENCES[1]), (1, None)):
        ax.plot(at, expected + sign * tolerance, ":", color=style.REFERENCE, linewidth=0.8, label=label)
