"""The first picture of the verdict: the trials themselves where they fit, else the leader against each rival."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import pandas as pd

from bench import analysis
from bench.analysis.cells import labels, scores
from bench.analysis.instances import SOLVED
from bench.analysis.subject import seen_from
from bench.plots import a12_forest, box_plot, style
from bench.report.parts import Figure
from bench.topics.findings import FEW, Findings

PROBLEMS, PROBLEMS_OF_TWO = 6, 12  # at most, of which all trials are drawn; the second of two optimizers
ONE_ROW = 4  # panels beside each other
RIVALS = 12  # of the leader, at most


def evidence(findings: Findings, clear: bool) -> Figure:
    """Return the picture of the evidence: every trial of few problems, else the leader against each rival.

    ``clear`` says that the tests show the leader to be lower than every rival.
    """
    if not shows_trials(findings):
        return leader_figure(findings.final.overall, findings.from_leader, clear)
    trials, errors = findings.trials, {}
    if findings.anytime.target_set.absolute:  # elsewhere 1e-8 means nothing in the unit of a problem
        errors = {label: best for label, best in trials.unbeaten.items() if label not in trials.pooled.functions}
    above = trials.frame["problem"].astype(object).map(errors).astype(float).fillna(0.0)
    frame = trials.frame.assign(fun=trials.frame["fun"] - above)
    solved = {*trials.pooled.functions, *errors}
    return trials_figure(frame, list(findings.final.medians.index), trials.optima, solved, findings.display.pens)


def leader_figure(tests: pd.DataFrame, ranked: Sequence[str], clear: bool) -> Figure:
    """Return the probability that a run of the first optimizer ends lower than one of each rival, the nearest ones.

    ``tests`` are those of :func:`bench.analysis.across_problems`.
    """
    leader, rivals = ranked[0], ranked[1 : RIVALS + 1]
    pairs = seen_from(tests, leader).set_index("second").loc[list(rivals)].reset_index()
    pairs = pairs.assign(significant=pairs["significant"] | clear)
    names = style.names(rivals, 18)
    left = style.text_width(names.values(), style.SMALL) + 0.25
    figure, (ax,) = style.grid(
        1, width=style.COLUMN, height=style.rows_height(len(pairs)), left=left, bottom=0.36, top=0.08
    )
    a12_forest(pairs, names=list(names.values()), ax=ax)
    ax.set_xlabel(f"probability that a run of {style.plain(leader, 24)} ends lower", loc="right")
    more = f" The {len(rivals)} nearest rivals." if len(ranked) > len(rivals) + 1 else ""
    caption = (
        f"{leader} against each rival, averaged over these problems, with 95% intervals that hold for all pairs "
        f"together; right of the line it ends lower. Filled: the test shows it.{more}"
    )
    return Figure("leader-against-each", caption, figure, pairs)


def shows_trials(findings: Findings) -> bool:
    """Return whether the first picture shows every trial: of few problems, or of two optimizers."""
    optimizers = len(findings.trials.optimizers)
    most = PROBLEMS_OF_TWO if optimizers == 2 else PROBLEMS
    return len(findings.final.medians) <= most and optimizers <= FEW


def trials_figure(
    frame: pd.DataFrame,
    problems: Sequence[str],
    optima: Mapping[str, float],
    solved: Collection[str],
    pens: style.Pens,
) -> Figure:
    """Return box plots with a point for every trial, a panel a problem.

    ``solved`` are the problems whose values are precisions, which are drawn from :data:`bench.analysis.SOLVED` on.
    """
    optimizers = labels(frame, "optimizer")
    drawn = frame[frame["problem"].isin(problems)]
    summary = analysis.summarise(drawn)
    summary = summary[summary["problem"].isin(problems)].set_index(["problem", "optimizer"])
    unfinished = not style.drawable(scores(drawn)).all() or bool((summary["n"] == 0).any())
    beside = 0.7 if unfinished else 0.1  # for the number of failed trials
    columns = {5: 3, 6: 3}.get(len(problems), ONE_ROW)
    figure, axes = style.grid(
        len(problems), columns=columns, width=style.COLUMN if len(problems) == 1 else style.PAGE,
        height=style.rows_height(len(optimizers)), bottom=0.36, top=0.3, right=beside, across=beside + 0.08, down=0.5,
        left=style.text_width(style.names(optimizers).values(), style.SMALL) + 0.12,
    )  # fmt: skip
    for place, (problem, ax) in enumerate(zip(problems, axes, strict=True)):
        least = SOLVED if problem in solved else None
        optimum = optima.get(problem) if least is None else None  # it is 0, off a log axis
        box_plot(frame, problem, optimum=optimum, least=least, pens=pens, ax=ax)
        style.title(ax, problem, 24)
        if least is not None and len(problems) > 1:
            ax.set_xlabel("error")  # which the caption explains: a panel has no room for more
        if (legend := ax.get_legend()) is not None:
            legend.remove()  # the caption says what the line is
        if place % columns:
            ax.set_yticks([])
    line = (
        " Line: the optimum, where it is known and on the axis." if set(problems) & optima.keys() - set(solved) else ""
    )
    floor = ""
    if set(problems) & set(solved):
        floor = f" The error is the value less the optimum; those below {SOLVED:g} are drawn there."
    caption = (
        "Every trial (points), with quartile boxes; the line in a box is the median. Lower (further left) is "
        f"better.{line}{floor} Failed trials are counted, not drawn."
    )
    data = drawn[["problem", "optimizer", "trial", "seed", "status", "fun"]]
    shown = summary[["n", "failed", "best", "q1", "median", "q3", "worst"]]
    return Figure("every-trial", caption, figure, data, shown)
