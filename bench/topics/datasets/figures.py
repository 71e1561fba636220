"""The distribution of every trial on one problem."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd

from bench.analysis.cells import labels, scores
from bench.plots import box_plot, style
from bench.report.parts import Figure
from bench.report.wording import listing
from bench.topics.figures import COLUMNS, figure_width, left_margin


def distribution_figure(
    frame: pd.DataFrame,
    problem: str,
    optimum: float | None,
    expected: Mapping[str, tuple[float, float]],
    least: float | None = None,
    best: Sequence[str] | None = None,
) -> Figure:
    """Return box plots of one problem: the objective value, and each domain metric whose true value is known.

    ``expected`` holds the true value and the tolerance of domain metrics, by name. ``least`` is the precision from
    which on a problem is solved, where the objective values are precisions. ``best`` are
    the optimizers to draw, in their order; all by default.
    """
    metrics = {name: value for name, value in expected.items() if name in frame}
    rows, all_of_them = frame[frame["problem"] == problem], len(labels(frame, "optimizer"))
    if best is not None and len(best) < all_of_them:
        frame = frame[frame["optimizer"].isin(best)]
        frame = frame.assign(optimizer=pd.Categorical(frame["optimizer"].astype(object), categories=list(best)))
    optimizers = labels(frame, "optimizer")
    drawn = frame[frame["problem"] == problem]
    noted = not style.drawable(scores(drawn)).all() or set(optimizers) > set(drawn["optimizer"])
    beside = 0.7 if noted else 0.1  # for the number of failed trials
    left = left_margin(style.names(optimizers).values())
    figure, axes = style.grid(
        1 + len(metrics), columns=COLUMNS, width=style.PAGE if metrics else figure_width(left),
        height=style.rows_height(len(optimizers)), left=left,
        right=beside, across=beside + 0.1, down=0.7, bottom=0.36, top=0.22,
    )  # fmt: skip
    pens = style.pens(optimizers)
    optimum = optimum if least is None else None  # it is 0, off a log axis
    box_plot(frame, problem, optimum=optimum, least=least, pens=pens, ax=axes[0])
    for place, (name, (value, tolerance)) in enumerate(metrics.items(), 1):
        box_plot(frame, problem, column=name, expected=value, tolerance=tolerance, pens=pens, ax=axes[place])
        axes[place].set_title("", loc="left")
        if place % COLUMNS:
            axes[place].set_yticks([])
    lines = ["the optimum"] if optimum is not None else []
    lines += ["the true values (hatched: their tolerances)"] if metrics else []
    some = (
        f"{problem}, the {len(optimizers)} best of {all_of_them} optimizers"
        if len(optimizers) < all_of_them
        else problem
    )
    truth = f"Line{'s' if metrics else ''}: {listing(lines)}. " if lines else ""
    solved = "" if least is None else f"Trials that solved an instance, to {least:g}, are drawn at that value. "
    caption = (
        f"{some}: every trial (points), with quartile boxes and whiskers to the furthest point within 1.5 box "
        f"lengths; the line in a box is the median. {truth}{solved}Failed trials are counted, not drawn."
    )
    data = rows[["problem", "optimizer", "trial", "seed", "status", "fun", *metrics]]
    if least is not None:
        data = data.rename(columns={"fun": "precision"})
    return Figure(f"distribution-{problem}", caption, figure, data, data.drop(columns=["problem", "seed"]))
