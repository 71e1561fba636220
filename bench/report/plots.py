"""The figures of the built-in sections, drawn from frames."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cbook import boxplot_stats
from matplotlib.lines import Line2D

from bench.analysis import best_so_far, cells, evaluation_grid, scores
from bench.report import style
from bench.report.findings import Findings
from bench.report.parts import Figure
from bench.report.words import seconds


def distribution_figure(findings: Findings) -> Figure:
    """Return box plots of every cell with all of its points, a panel a problem."""
    optimizers, looks = findings.optimizers, style.looks(findings.optimizers)
    data = findings.frame[["problem", "optimizer", "trial", "seed", "status", "fun"]]
    data = data.assign(score=scores(findings.frame))
    wide = any(style.is_wide(group["score"]) for _, group in data.groupby("problem", observed=True))
    figure, axes = style.panels(len(findings.problems), height=0.45 + 0.27 * len(optimizers), margin=0.1, sharey=True)
    for ax, problem in zip(axes, findings.problems, strict=True):
        for row, optimizer in enumerate(optimizers):
            values = data.loc[(data["problem"] == problem) & (data["optimizer"] == optimizer), "score"].to_numpy()
            _box(ax, row, values, looks[optimizer], many=len(data) > style.MANY_POINTS)
        ax.set_title(style.plain(problem), loc="left")
        if wide and (data.loc[data["problem"] == problem, "score"] > 0).all():
            style.log_scale(ax, "x")
        ax.grid(visible=False, axis="y")
        ax.use_sticky_edges = False
    axes[0].set_yticks(range(len(optimizers)), [style.plain(label, 16) for label in optimizers])
    axes[0].set_ylim(len(optimizers) - 0.4, -0.6)
    caption = (
        "Best objective value of every trial (points), with quartile boxes and whiskers to the furthest point within "
        "1.5 box lengths; the line in the box is the median. Failed trials are counted, not drawn."
    )
    return Figure("distributions", caption, figure, data)


def _box(ax: Axes, row: int, values: np.ndarray, look: style.Look, *, many: bool) -> None:
    """Draw one horizontal box with its points; written out because matplotlib renamed its own option for it."""
    finite = values[np.isfinite(values)]
    if failed := len(values) - len(finite):
        ax.text(0.995, row, f"{failed} failed", transform=ax.get_yaxis_transform(), ha="right", va="center", fontsize=7)
    if not len(finite):
        return
    box = boxplot_stats(finite)[0]
    ax.hlines(row, box["whislo"], box["whishi"], color="black", linewidth=0.8, zorder=2)
    ax.barh(
        row, box["q3"] - box["q1"], left=box["q1"], height=0.62, facecolor="white", edgecolor="black", linewidth=0.8
    )
    offsets = row + style.spread(len(finite))
    ax.plot(
        finite,
        offsets,
        look.marker,
        color=look.color,
        markersize=3,
        markeredgewidth=0,
        alpha=0.7,
        zorder=3,
        rasterized=many,
    )
    ax.vlines(box["med"], row - 0.31, row + 0.31, color="black", linewidth=1.6, zorder=4)


def convergence_figure(findings: Findings) -> Figure:
    """Return the median best-so-far value over evaluations with its quartiles, a panel a problem."""
    looks, data = style.looks(findings.optimizers), _convergence(findings)
    figure, axes = style.panels(len(findings.problems), height=1.9, sharex=True)
    for ax, problem in zip(axes, findings.problems, strict=True):
        panel = data[(data["problem"] == problem) & np.isfinite(data["median"])]
        for i, (optimizer, look) in enumerate(looks.items()):
            curve = panel[panel["optimizer"] == optimizer]
            if len(curve):
                _curve(ax, curve, look, first_marker=2 * i)
        ax.set_title(style.plain(problem), loc="left")
        style.log_scale(ax, "x")
        if style.is_wide(panel["median"], ratio=3):
            style.log_scale(ax, "y")
    for ax in axes[-3:]:
        ax.set_xlabel("evaluations")
        ax.xaxis.set_tick_params(labelbottom=True)
    handles = [
        Line2D(
            [], [], color=look.color, linestyle=look.line, marker=look.marker, markersize=4, label=style.plain(label)
        )
        for label, look in looks.items()
    ]
    figure.legend(handles=handles, loc="outside upper left", ncols=min(len(handles), 6))
    caption = (
        "Median best-so-far objective value over evaluations, with the quartiles as a band (log axes where the "
        "values are positive and wide). A trial that ended early keeps its last value; failed trials count as infinite."
    )
    return Figure("convergence", caption, figure, data)


def _convergence(findings: Findings) -> pd.DataFrame:
    grid = evaluation_grid(findings.results.study.budget)
    curves = []
    for (problem, optimizer), values in cells(findings.frame).items():
        traces = list(findings.results.traces(problem, optimizer).values())
        curve = best_so_far(traces, grid, failed=len(values) - len(traces))
        curve.insert(0, "problem", problem)
        curve.insert(1, "optimizer", optimizer)
        curves.append(curve)
    return pd.concat(curves, ignore_index=True)


def _curve(ax: Axes, curve: pd.DataFrame, look: style.Look, *, first_marker: int) -> None:
    banded = curve[np.isfinite(curve["q3"])]
    ax.fill_between(banded["evaluations"], banded["q1"], banded["q3"], color=look.color, alpha=0.18, linewidth=0)
    ax.plot(
        curve["evaluations"], curve["median"], color=look.color, linestyle=look.line, linewidth=1.2, marker=look.marker,
        markersize=3.5, markevery=(first_marker % 12, 12),
    )  # fmt: skip


def timing_figure(timing: pd.DataFrame) -> Figure:
    """Return the mean time of one trial of each optimizer (thesis Fig. 7.5), split into objective and the rest."""
    known = timing[timing["trials"] > 0]
    figure, (ax,) = style.panels(1, width=8.0, height=0.35 * len(known) + 0.6)
    parts = {
        "in the objective": known["objective_mean"],
        "in the optimizer": known["wall_mean"] - known["objective_mean"],
    }
    left = np.zeros(len(known))
    for (name, width), color, hatch in zip(parts.items(), style.PALETTE, style.HATCHES, strict=False):
        ax.barh(
            range(len(known)), width, left=left, height=0.6, color=color, hatch=hatch, edgecolor="white", label=name
        )
        left = left + width.to_numpy()
    for row, mean in enumerate(known["wall_mean"]):
        ax.text(mean, row, f" {seconds(mean)}", va="center")
    ax.set_yticks(range(len(known)), [style.plain(label) for label in known["optimizer"]])
    ax.invert_yaxis()
    ax.margins(x=0.12)
    ax.grid(visible=False, axis="y")
    ax.set_xlabel("mean wall time of one trial in seconds")
    figure.legend(loc="outside upper left", ncols=2)
    data = known[["optimizer", "trials", "wall_mean", "objective_mean"]]
    return Figure("mean-time", "Mean wall time of one trial of each optimizer over all problems.", figure, data)
