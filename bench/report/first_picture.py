"""The first picture of the verdict: the trials themselves where they fit, else the ranks over the budget."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import pandas as pd

from bench import analysis
from bench.analysis.cells import labels
from bench.plots import box_plot, style
from bench.report.findings import MANY_OPTIMIZERS, Findings
from bench.report.parts import Figure
from bench.report.plots import course_figure

PROBLEMS, PROBLEMS_OF_TWO = 6, 12  # at most, of which all trials are drawn; the second of two optimizers
ONE_ROW = 4  # panels beside each other


def first_picture(findings: Findings) -> list[Figure]:
    """Return the picture beside the verdict, none where neither trials nor traces can be drawn."""
    if shows_trials(findings):
        solved = set(findings.trials.pooled.functions)
        return [
            trials_figure(
                findings.trials.frame, findings.trials.problems, findings.trials.optima, solved, findings.display.pens
            )
        ]
    return course(findings)


def shows_trials(findings: Findings) -> bool:
    """Return whether the first picture shows every trial: of few problems, or of two optimizers."""
    optimizers = len(findings.trials.optimizers)
    most = PROBLEMS_OF_TWO if optimizers == 2 else PROBLEMS
    return len(findings.trials.problems) <= most and optimizers <= MANY_OPTIMIZERS


def course(findings: Findings) -> list[Figure]:
    """Return the figure of the ranks over the budget, none without a trace."""
    return (
        [course_figure(findings.anytime.stages, findings.display.pens)]
        if findings.trials.traces and len(findings.anytime.stages)
        else []
    )


def trials_figure(
    frame: pd.DataFrame,
    problems: Sequence[str],
    optima: Mapping[str, float],
    solved: Collection[str],
    pens: style.Pens,
) -> Figure:
    """Return box plots with a point for every trial, a panel a problem.

    ``solved`` are the problems whose objective values are precisions, which are drawn from
    :data:`bench.analysis.SOLVED` on.
    """
    optimizers = labels(frame, "optimizer")
    drawn = frame[frame["problem"].isin(problems)]
    summary = analysis.summarise(drawn)
    summary = summary[summary["problem"].isin(problems)].set_index(["problem", "optimizer"])
    unfinished = not style.drawable(analysis.scores(drawn)).all() or bool((summary["n"] == 0).any())
    beside = 0.7 if unfinished else 0.1  # for the number of failed trials
    columns = {5: 3, 6: 3}.get(len(problems), ONE_ROW)
    figure, axes = style.grid(
        len(problems), columns=columns, width=style.COLUMN if len(problems) == 1 else style.TEXT,
        height=style.rows_height(len(optimizers)), bottom=0.36, top=0.3, right=beside, across=beside + 0.08, down=0.5,
        left=style.text_width(style.names(optimizers).values(), style.SMALL) + 0.12,
    )  # fmt: skip
    for place, (problem, ax) in enumerate(zip(problems, axes, strict=True)):
        least = analysis.SOLVED if problem in solved else None
        optimum = optima.get(problem) if least is None else None  # it is 0, off a log axis
        box_plot(frame, problem, optimum=optimum, least=least, pens=pens, ax=ax)
        ax.set_title(style.plain(problem, 24), loc="left")
        if (legend := ax.get_legend()) is not None:
            legend.remove()  # the caption says what the line is
        if place % columns:
            ax.set_yticks([])
    line = (
        " Line: the optimum, where it is known and on the axis." if set(problems) & optima.keys() - set(solved) else ""
    )
    floor = f" Precisions below {analysis.SOLVED:g} are drawn there." if set(problems) & set(solved) else ""
    caption = (
        "Every trial (points), with quartile boxes; the line in a box is the median. Lower (further left) is "
        f"better.{line}{floor} Failed trials are counted, not drawn."
    )
    data = drawn[["problem", "optimizer", "trial", "seed", "status", "fun"]]
    shown = summary[["n", "failed", "best", "q1", "median", "q3", "worst"]]
    return Figure("every-trial", caption, figure, data, shown)
