"""Figs. 7.3 to 7.5: the gap and the amplitude that trials found beside the true ones, and the time of a trial."""

from __future__ import annotations

import re
import warnings
from math import ceil

import matplotlib.figure
import numpy as np
import pandas as pd
import seaborn
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from bench.plots import style, timing
from bench.report import Figure
from bench.topics import Findings
from problems.backlash.report.accuracy import with_truth
from problems.backlash.signature.problem import TOLERANCE_RPM

LEFT, ACROSS = 0.45, 0.1  # inches
LABEL = 18  # characters of a dataset's name, such as "noisy-02 high"
MOST, CROWD = 10, 12  # optimizers that a figure shows where there are more than a crowd
SHOWN = {"backlash_rad": ("half-gap δ in 1e-6 rad", 1e6), "amplitude_rpm": ("amplitude |A| in rpm", 1.0)}
EXPECTED, BAND = "true value", "accuracy band"


def drawn(findings: Findings, found: dict[str, pd.DataFrame]) -> list[Figure]:
    """Return the figures of the metrics that trials found, and of the time of a trial."""
    ranked = findings.from_leader
    shown = ranked[:MOST] if len(ranked) > CROWD else findings.trials.optimizers
    figures = []
    truths = {name: with_truth(found[name]) for name in SHOWN if name in found}
    if any(map(len, truths.values())):
        figures.append(figure_7_3({name: data for name, data in truths.items() if len(data)}, shown))
    if "amplitude_rpm" in found:
        figures.append(figure_7_4(found["amplitude_rpm"], shown))
    times = findings.trials.timing
    times = times[times["wall_mean"].notna() & times["optimizer"].isin(shown)]
    return [*figures, figure_7_5(times)] if len(times) else figures


def figure_7_3(found: dict[str, pd.DataFrame], optimizers: list[str]) -> Figure:
    """Return the true gap and amplitude of each dataset, with the quartiles of what trials found."""
    names = [style.plain(optimizer) for optimizer in optimizers]
    first = next(iter(found.values()))
    problems = list(first["problem"].cat.categories)
    drawing, axes = panels([SHOWN[name][0] for name in found], problems, [EXPECTED, BAND, *names], columns=1)
    pens = style.pens(optimizers)
    colours = {name: pens[label].color for name, label in zip(names, optimizers, strict=True)}
    for ax, (name, data) in zip(axes, found.items(), strict=True):
        scale = SHOWN[name][1]
        truth = data.groupby("problem", observed=False)[["expected", "tolerance"]].first().reindex(problems) * scale
        _truth(ax, truth)
        boxes(ax, _places(data, problems, optimizers, names, scale), hue="optimizer", palette=colours, whis=0)
    boxed = [
        Patch(facecolor=colour, edgecolor=style.DARK, linewidth=0.6, label=name) for name, colour in colours.items()
    ]
    style.legend_above(drawing, [*axes[0].get_legend_handles_labels()[0], *boxed])
    caption = (
        "The true half-gap of each dataset and the amplitude expected of it (lines; shaded: accuracy bands), and the "
        "quartiles and median of what each optimizer’s runs found (thesis Fig. 7.3)."
    )
    return Figure("figure-7-3", caption, drawing, quartiles(found))


def figure_7_4(data: pd.DataFrame, optimizers: list[str]) -> Figure:
    """Return box plots of the amplitude found, a panel for each optimizer."""
    problems = list(data["problem"].cat.categories)
    drawing, axes = panels(optimizers, problems, [EXPECTED, BAND], columns=3)
    truth = data.groupby("problem", observed=False)[["expected", "tolerance"]].first()
    for ax, optimizer in zip(axes, optimizers, strict=True):
        _truth(ax, truth)
        rows = data[data["optimizer"] == optimizer]
        boxes(ax, _places(rows, problems, [optimizer], [optimizer], 1.0), color="white", fliersize=2)
    for ax in axes[::3]:
        ax.set_ylabel("|A| in rpm")
    if truth["expected"].notna().any():
        style.legend_above(drawing, axes[0].get_legend_handles_labels()[0])
    caption = (
        "Amplitude found on each dataset (whiskers: 1.5 times the interquartile range). Line: the expected amplitude; "
        f"shaded: ±{TOLERANCE_RPM:.4f} rpm (thesis Fig. 7.4)."
    )
    return Figure("figure-7-4", caption, drawing, data, quartiles({"amplitude_rpm": data}))


def figure_7_5(times: pd.DataFrame) -> Figure:
    """Return the mean time of a trial of each optimizer, split into the objective and the rest."""
    left = style.text_width(style.names(times["optimizer"]).values()) + 0.1
    drawing, (ax,) = style.grid(
        1, width=style.COLUMN, height=style.rows_height(len(times)), left=min(left, style.COLUMN / 2), top=0.25
    )
    timing(times, ax=ax)
    data = times[["optimizer", "trials", "wall_mean", "objective_mean"]]
    return Figure("figure-7-5", "Mean wall time of a run of each optimizer (thesis Fig. 7.5).", drawing, data)


def quartiles(found: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """Return a row for each metric, problem and optimizer: true value, tolerance, numbers of trials, quartiles."""
    tables = []
    for name, data in found.items():
        groups = data.groupby(["problem", "optimizer"], observed=True)
        table = groups.agg(
            expected=("expected", "first"), tolerance=("tolerance", "first"), trials=("trial", "size"),
            found=("found", "count"),
        )  # fmt: skip
        table[["q1", "median", "q3"]] = groups["found"].quantile(np.array([0.25, 0.5, 0.75])).unstack()
        tables.append(table.reset_index().assign(figure=name))
    return pd.concat(tables, ignore_index=True).set_index("figure").reset_index()


def boxes(ax: Axes, data: pd.DataFrame, **look: object) -> None:
    """Draw box plots of ``value`` at each ``place``; whiskers that end at the quartiles have no points beyond them."""
    thin = {"linewidth": 0.6, "showcaps": False, "linecolor": style.DARK, "legend": False, "native_scale": True}
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "vert: bool")  # seaborn 0.13 uses this option, which matplotlib deprecates
        seaborn.boxplot(data, x="place", y="value", ax=ax, showfliers=look.get("whis") != 0, **thin, **look)
    ax.set(xlabel=ax.get_xlabel() and "dataset", ylabel="")


def _places(
    data: pd.DataFrame, problems: list[str], optimizers: list[str], names: list[str], scale: float
) -> pd.DataFrame:
    """Return place (of the dataset), optimizer (its name in the figure) and value of the trials that found one."""
    rows = data[data["found"].notna() & data["optimizer"].isin(optimizers)]
    place = rows["problem"].astype(object).map({label: number for number, label in enumerate(problems)}).astype(int)
    named = rows["optimizer"].astype(object).map(dict(zip(optimizers, names, strict=True)))
    return pd.DataFrame(
        {"place": place, "optimizer": pd.Categorical(named, categories=names), "value": scale * rows["found"]}
    )


def _truth(ax: Axes, truth: pd.DataFrame) -> None:
    """Draw each true value with its band in grey, as the colours mean optimizers."""
    at, expected, tolerance = np.arange(len(truth)), truth["expected"], truth["tolerance"]
    if expected.isna().all():
        return
    ax.bar(at, 2 * tolerance, 0.9, expected - tolerance, color="0.85", label=BAND)
    ax.hlines(expected, at - 0.45, at + 0.45, color=style.REFERENCE, linewidth=0.9, label=EXPECTED, zorder=4)


def panels(
    titles: list[str], problems: list[str], entries: list[str], *, columns: int
) -> tuple[matplotlib.figure.Figure, list[Axes]]:
    """Return a figure as wide as the text and its titled axes, row by row, with the datasets at 0, 1, … of the x axis.

    Args:
        titles: a title for each panel; panels side by side share their y axis.
        problems: the labels of the datasets.
        entries: the texts of the legend above all panels (:func:`bench.plots.style.legend_above`), at most.
        columns: panels in a row.
    """
    names = [style.plain(short(problem), LABEL) for problem in problems]
    longest, digits = style.text_width(names), style.text_width(["00"])
    upright, columns = longest <= digits, min(columns, len(titles))
    figure, axes = style.grid(
        len(titles), columns=columns, height=1.7 if columns == 1 else 1.4, left=LEFT,
        bottom=0.36 + (0 if upright else longest), top=0.25 + style.legend_height(entries), across=ACROSS, down=0.3,
    )  # fmt: skip
    width = (style.PAGE - LEFT) / columns - ACROSS
    every = ceil(len(names) * (longest + 0.06 if upright else 0.12) / width)
    for number, (ax, title) in enumerate(zip(axes, titles, strict=True)):
        if number:
            ax.sharex(axes[0])
        if number and columns > 1:
            ax.sharey(axes[0])
            ax.tick_params(axis="y", labelleft=number % columns == 0)
        style.title(ax, title)
        ax.grid(visible=False, axis="x")
        last = number >= len(axes) - columns
        ax.tick_params(axis="x", rotation=0 if upright else 90, labelbottom=last)
        if last:
            ax.set_xlabel("dataset")
    axes[0].set_xticks(range(0, len(names), every), names[::every])
    axes[0].set_xlim(-0.7, len(names) - 0.3)
    return figure, axes


def short(problem: str) -> str:
    """Return the number of a simulated or published dataset, any other label unchanged."""
    return re.sub(r"^(signature|published)-0*(?=\d+$)", "", problem)
