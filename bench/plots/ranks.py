"""Critical-difference diagrams, ranks over the budget, and forest plots of how often one of two does better."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import log

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from bench.analysis.pairwise import CUTOFFS
from bench.plots import style

MOST_NAMES = 60  # names in a critical-difference diagram; more would not fit on a page
RANK_NAME = 20  # characters of a name there
LINE, BAR = 0.15, 0.09  # inches between its names, and between its bars
LEADER = 0.14  # inches between the end of a curve and its name
AXES = {"evaluations": "evaluations", "trials": "trials", "share": "share of the budget"}  # of ranks, with their names
EFFECTS = [bound for cutoff in CUTOFFS.values() for bound in (1 - cutoff, cutoff)]  # on both sides of 0.5


def rank_course(ranks: pd.DataFrame, *, pens: style.Pens | None = None, ax: Axes | None = None) -> Axes:
    """Draw the mean rank of each optimizer over the evaluations, the best at the top, with its name at the right.

    ``ranks`` has optimizer, evaluations (or share, of the budget, or trials) and rank, a row a stage, and low and high
    where a band is to be drawn. Optimizers whose pen is in the background (:func:`bench.plots.style.pens`) have
    neither name nor band.
    """
    pens = style.pens_of(ranks, pens)
    ax = style.own_axes(ax)
    along = next(name for name in AXES if name in ranks)
    shown = style.names(pens, RANK_NAME)
    last: dict[str, float] = {}
    for optimizer, pen in style.behind_first(pens):
        x, y = ranks.loc[ranks["optimizer"] == optimizer, [along, "rank"]].to_numpy(dtype=float).T
        if not len(x):
            continue
        ax.plot(
            x, y, color=pen.color, linestyle=pen.line, linewidth=0.6 if pen.background else 1.3 * pen.width,
            marker="" if pen.background else pen.marker, markersize=4.0, clip_on=False,
        )  # fmt: skip
        if not pen.background:
            last[optimizer] = float(y[-1])
        if not pen.background and "low" in ranks:
            low, high = ranks.loc[ranks["optimizer"] == optimizer, ["low", "high"]].to_numpy(dtype=float).T
            ax.fill_between(x, low, high, color=pen.color, alpha=0.15, linewidth=0)
    drawn = ranks[[name for name in ("rank", "low", "high") if name in ranks]]
    least, most = float(drawn.to_numpy(dtype=float).min()), float(drawn.to_numpy(dtype=float).max())
    room = max(most - least, 1.0)
    ax.set_ylim(most + 0.05 * room, max(least - 0.05 * room, 0.5))
    ax.yaxis.set_major_locator(MaxNLocator(6, integer=True))
    style.log_scale(ax, "x")
    stages = sorted(ranks[along].unique())
    panel = ax.get_window_extent()
    width, height = panel.width / ax.figure.dpi, panel.height / ax.figure.dpi
    ax.set_xticks(
        stages, legible([f"{stage:.0%}" if along == "share" else f"{stage:,.0f}" for stage in stages], stages, width)
    )
    ax.set_xlim(stages[0], stages[-1])
    beside = ax.get_yaxis_transform()
    for optimizer, place in moved_apart(last, 1.1 * room * LINE / height, least).items():
        color = pens[optimizer].color
        ax.plot(
            [1.0, 1.0 + LEADER / width], [last[optimizer], place], color=color, linewidth=0.7, transform=beside,
            clip_on=False,
        )  # fmt: skip
        ax.text(1.0 + (LEADER + 0.03) / width, place, shown[optimizer], transform=beside, va="center", color=color)
    ax.set_ylabel("mean rank")
    ax.set_xlabel(AXES[along])
    return ax


def legible(texts: Sequence[str], stages: Sequence[float], width: float) -> list[str]:
    """Return the texts of ticks on a log axis of a width in inches, "" for those that would touch the next one."""
    shown: list[str] = []
    free = float("inf")
    for text, stage in reversed(list(zip(texts, stages, strict=True))):
        at = width * log(stage / stages[0]) / (log(stages[-1] / stages[0]) or 1.0)
        half = style.text_width([text], style.SMALL) / 2
        fits = at + half + 0.06 <= free
        shown.append(text if fits else "")
        free = at - half if fits else free
    return shown[::-1]


def moved_apart(places: Mapping[str, float], gap: float, least: float) -> dict[str, float]:
    """Return places at least a gap apart and none below the least; those that are too near are spread evenly."""
    groups: list[list[tuple[str, float]]] = []
    for item in sorted(places.items(), key=lambda item: item[1]):
        groups.append([item])
        while len(groups) > 1 and _start(groups[-1], gap, least) < _start(groups[-2], gap, least) + gap * len(
            groups[-2]
        ):
            groups[-2:] = [groups[-2] + groups[-1]]
    return {
        name: _start(group, gap, least) + gap * number for group in groups for number, (name, _) in enumerate(group)
    }


def _start(group: Sequence[tuple[str, float]], gap: float, least: float) -> float:
    """Return the place of the first of a group about the mean of its places."""
    mean = sum(place for _, place in group) / len(group)
    return max(mean - gap * (len(group) - 1) / 2, least)


def a12_forest(
    pairs: pd.DataFrame, problem: str | None = None, *, names: Sequence[str] | None = None, ax: Axes | None = None
) -> Axes:
    """Draw how often the first of two optimizers does better, with its interval, in a row per pair.

    At 0.5 neither tends to be better; the faint lines are the bounds of small, medium and large effects by Vargha and
    Delaney (2000). A point is filled where its pair is significant.

    Args:
        pairs: the rivals of :func:`bench.analysis.comparison.compare`, with the intervals of the tests that fill the
            points; or pairs of :func:`bench.analysis.across_problems` or :func:`bench.analysis.pairwise_tests`, whose
            joint intervals are drawn.
        problem: the label of the problem to draw, where ``pairs`` has several.
        names: of the rows; by default the rivals, or "A vs B".
    """
    rows = pairs if problem is None else style.rows_of(pairs, problem)
    ax = style.own_axes(ax, height=style.rows_height(len(rows)) + 0.6)
    against = "outcome" in rows
    number = "chance" if against else "probability" if "probability" in rows else "a12"
    ends = ["low", "high"] if against else ["joint_low", "joint_high"]
    chance, low, high = rows[[number, *ends]].to_numpy(dtype=float).T
    at = np.arange(len(rows))
    ax.vlines(EFFECTS, 0, 1, color="#BBBBBB", linewidth=0.5, linestyle=":", transform=ax.get_xaxis_transform())
    ax.axvline(0.5, color="black", linewidth=0.7)
    ax.hlines(at, low, high, color=style.PALETTE[0], linewidth=1.6)
    clear = (rows["outcome"] != "open" if against else rows["significant"]).to_numpy(dtype=bool)
    for which, face in ((clear, style.PALETTE[0]), (~clear, "white")):
        ax.plot(chance[which], at[which], "o", color=style.PALETTE[0], markerfacecolor=face, markersize=4.0, zorder=3)
    if names is None:
        names = list(style.names(rows["rival"], 18).values()) if against else forest_names(rows)
    style.name_rows(ax, names)
    ax.set_xlim(-0.03, 1.03)
    ax.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0", "0.25", "0.5", "0.75", "1"])
    ax.grid(visible=False)
    ax.set_xlabel("chance that the first ends lower\n← second better | first better →")
    return ax


def forest_names(pairs: pd.DataFrame) -> list[str]:
    """Return the labels of the rows of a forest plot."""
    names = style.names(dict.fromkeys([*pairs["first"], *pairs["second"]]), 18)
    return [f"{names[first]} vs {names[second]}" for first, second in zip(pairs["first"], pairs["second"], strict=True)]
