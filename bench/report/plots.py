"""The figures of the report: :mod:`bench.plots` in panels, sized for papers, with the data behind them.

Frames come from the function of :mod:`bench.analysis` of the same purpose. ``optimizers`` are all optimizers of the
study, in its order, so that each has the same pen in every figure, or their pens.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from math import ceil, floor, log10

import matplotlib.figure
import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from bench.analysis import SOLVED
from bench.analysis.cells import NEAR, labels, scores
from bench.analysis.portfolio import Portfolio
from bench.plots import (
    a12_forest,
    box_plot,
    cd_diagram,
    convergence,
    data_profile,
    ecdf,
    ert,
    ert_scatter,
    rank_course,
    regret,
    scaling,
    style,
    timing,
)
from bench.plots.curves import MOST_BANDS
from bench.plots.ranks import RANK_NAME, cd_height, forest_names
from bench.plots.rows import shares
from bench.report.findings import BEST
from bench.report.parts import Figure
from bench.report.wording import listing
from bench.study.targets import KINDS, Targets

SHOWN_ROWS = 300  # of the table behind a figure
MOST_ROWS = 40  # of a figure with a row for each optimizer: more could not all be named
COLUMNS = 3  # panels beside each other
TITLE_LETTERS = 30  # of a line of small text above a panel


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
    left = _left(style.names(optimizers).values())
    figure, axes = style.grid(
        1 + len(metrics), columns=COLUMNS, width=style.TEXT if metrics else _width(left),
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


def convergence_figure(curves: pd.DataFrame, optimizers: Iterable[str], suffix: str = "") -> Figure:
    """Return the median best-so-far value over evaluations with its quartiles, a panel a problem.

    ``suffix`` ends the figure's name, where there are several of the kind.
    """
    caption = (
        f"Median best-so-far objective value over evaluations{_banded(optimizers)} (log axes where the "
        "values are positive and wide). A trial that ended early keeps its last value; failed trials count as infinite."
    )
    return _over_evaluations(f"convergence{suffix}", caption, convergence, curves, optimizers)


def regret_figure(
    curves: pd.DataFrame, optimizers: Iterable[str], suffix: str = "", *, precisions: Collection[str] = ()
) -> Figure:
    """Return the median regret over evaluations with its quartiles, a panel a problem whose optimum is known.

    ``suffix`` ends the figure's name, where there are several of the kind. On the problems ``precisions``, the regret
    is the precision of pooled instances.
    """
    pooled = curves["problem"].isin(precisions)
    counted = [] if pooled.any() and pooled.all() else [("problem", f"a relative {NEAR:g}")]
    counted += [("instance", f"{SOLVED:g}")] if pooled.any() else []
    whose, near = (" or ".join(words) for words in zip(*counted, strict=True))
    where = " where instances are pooled" if len(counted) > 1 else ""
    caption = (
        f"Median regret, the best-so-far objective value less the optimum of the {whose}, over "
        f"evaluations{_banded(optimizers)} (log axes). A curve ends where its median reaches the optimum, to {near}"
        f"{where}."
    )
    return _over_evaluations(f"regret-curves{suffix}", caption, regret, curves, optimizers)


def _banded(optimizers: Iterable[str]) -> str:
    return ", with the quartiles as a band" if len(list(optimizers)) <= MOST_BANDS else ""


def _over_evaluations(
    name: str, caption: str, draw: Callable[..., Axes], curves: pd.DataFrame, optimizers: Iterable[str]
) -> Figure:
    figure, axes = _multiples(curves, style.pens(optimizers), draw, across=0.46)
    for ax in axes:
        style.span(ax, curves["evaluations"])
    shown = _at_round_numbers(curves, ["problem", "evaluations"], "median", (1, 2, 5))
    return Figure(name, caption, figure, curves, shown)


def ert_figure(
    table: pd.DataFrame, optimizers: Iterable[str], suffix: str = "", *, chosen: Targets = KINDS["relative"]
) -> Figure:
    """Return the expected running time over targets, a panel a problem, all on the same axes.

    ``suffix`` ends the figure's name, where there are several of the kind.
    """
    figure, axes = _multiples(table, style.pens(optimizers), ert, across=0.12)
    for ax in axes:
        if chosen.unit != "tau" and ax.get_xlabel():
            ax.set_xlabel(chosen.unit)
    drawn = table[table["tau"] > 0]
    for place, ax in enumerate(axes):
        if len(drawn):
            ax.set_xlim(1.2 * drawn["tau"].max(), drawn["tau"].min() / 1.2)
            style.log_scale(ax, "x")
        if chosen.rising:
            ax.set_xticks(chosen.tabled, [chosen.shown(tau) for tau in chosen.tabled], minor=False)
        ax.tick_params(labelleft=place % COLUMNS == 0)
    _span_times(axes, drawn["ert"])
    caption = (
        "Expected running time (ERT) over targets, harder ones to the right. A curve ends at the hardest target that "
        "any trial reached, in an open marker where no trial reached the harder ones."
    )
    if set(table["problem"]) > set(drawn["problem"]):
        caption += " A panel is empty where the trials start at the reference, which is then the only target (tau = 0)."
    table = chosen.in_unit(table)
    by_target = _at_round_numbers(table, ["problem", "tau"], "ert", (1,))
    return Figure(f"expected-running-time{suffix}", caption, figure, table, by_target)


def ecdf_figure(
    reached: pd.DataFrame,
    profile: pd.DataFrame,
    optimizers: Iterable[str],
    *,
    target: str,
    ends: Mapping[str, float] | None = None,
) -> Figure:
    """Return two panels over evaluations: the share of targets reached, and the data profile at a ``target``.

    ``ends`` are the budgets, where ``reached`` are shares of simulated restarts; these may have the best of 2009.
    """
    pens = _beside(reached, optimizers)
    figure, (left, right) = style.grid(2, height=1.8, left=0.5, across=0.55, top=_legend_height(pens) + 0.1)
    data_profile(profile, pens=pens, legend=False, ax=right)
    ecdf(reached, pens=pens, legend=False, ax=left, ends=ends)
    style.legend_above(figure, style.handles(pens))
    along = "groups" if "groups" in profile else "evaluations"
    over = "per_dimension" if "per_dimension" in reached else "evaluations"
    unit = ", over groups of d + 1 evaluations" if along == "groups" else ""
    caption = (
        f"Left: the share of all targets, of all problems and {'simulated restarts' if ends else 'trials'}, that "
        f"was reached, over evaluations{' / d' if over == 'per_dimension' else ''}.{_ended(ends)} Right: the data "
        f"profile at {target}, the share of all trials that reached this one target{unit}."
    )
    panels = {"targets reached": (reached, over), "data profile": (profile, along)}
    data = pd.concat([frame.assign(panel=name) for name, (frame, _) in panels.items()], ignore_index=True)
    shown = pd.concat(
        {name: _at_round_numbers(frame, [by], "fraction", (1, 2, 5)) for name, (frame, by) in panels.items()},
        names=["panel", "evaluations" if along == over else "evaluations or groups"],
    )
    return Figure("targets-reached", caption, figure, data, shown)


def reached_figure(
    name: str,
    curves: pd.DataFrame,
    optimizers: Iterable[str],
    *,
    ends: Mapping[str, Mapping[str, float]] | None = None,
    what: str = "group",
    columns: int = COLUMNS,
) -> Figure:
    """Return the share of targets reached over evaluations / d, a panel a group of functions, or a function.

    ``curves`` are those of :func:`bench.analysis.ecdf` with a column problem, the panel's name, and may have the best
    of 2009; ``ends`` are the budgets by panel, where they are of simulated restarts.
    """
    pens = _beside(curves, optimizers)

    def draw(frame: pd.DataFrame, problem: str, *, pens: style.Pens, legend: bool, ax: Axes) -> Axes:
        ecdf(frame[frame["problem"] == problem], pens=pens, legend=legend, ax=ax, ends=(ends or {}).get(problem))
        unbroken = style.plain(problem, 2 * TITLE_LETTERS).replace(" = ", "\xa0=\xa0")
        lines = textwrap.wrap(unbroken, TITLE_LETTERS)
        ax.set_title("\n".join(lines), loc="left", fontsize="small")
        ax.set_ylabel("share reached")
        return ax

    longest = max((len(f"{label}") for label in labels(curves, "problem")), default=0)
    down = 0.4 if longest > TITLE_LETTERS else 0.28  # for titles of two lines
    figure, _ = _multiples(curves, pens, draw, across=0.46, down=down, columns=columns)
    caption = (
        f"The share of all targets, of all problems and {'simulated restarts' if ends else 'trials'} of a {what}, "
        f"that was reached, over evaluations / d. Higher and further left is better.{_ended(ends)}"
    )
    shown = _at_round_numbers(curves, ["problem", "per_dimension"], "fraction", (1,))
    return Figure(name, caption, figure, curves, shown)


def scatter_figure(table: pd.DataFrame, across: str, up: str) -> Figure:
    """Return the ERT of one optimizer over that of another, a point a problem and target.

    ``table`` has problem, kind (such as the dimension), target and the two ERTs in evaluations / d, by optimizer.
    """
    kinds = list(dict.fromkeys(table["kind"]))
    pens = {kind: style.Pen(style.PALETTE[i % 8], style.MARKERS[i % 7], "") for i, kind in enumerate(kinds)}
    figure, (ax,) = style.grid(
        1,
        width=style.COLUMN,
        height=2.4,
        left=0.55,
        right=0.15,
        bottom=0.45,
        top=_legend_height(pens, style.COLUMN) + 0.1,
    )
    ert_scatter(table, across, up, pens=pens, ax=ax)
    style.legend_above(figure, style.handles(pens))
    caption = (
        f"Expected running time / d of {up} over that of {across}, a point a problem and target. Above the diagonal, "
        f"{across} is faster. Dotted: infinite, as no trial reached the target."
    )
    return Figure("ert-scatter", caption, figure, table)


def _beside(curves: pd.DataFrame, optimizers: Iterable[str]) -> style.Pens:
    """Return the pens of the optimizers, and of the best of 2009 where there is a curve of it."""
    return dict(style.pens(optimizers)) | ({BEST: style.BESIDE} if (curves["optimizer"] == BEST).any() else {})


def _ended(ends: Mapping[str, object] | None) -> str:
    return " Crosses: the end of the budget; beyond it, restarts are simulated." if ends else ""


def scaling_figure(table: pd.DataFrame, optimizers: Iterable[str], *, target: str) -> Figure:
    """Return the expected running time to one target over the dimension, a panel a function.

    ``table`` has problem (the function), dimension, optimizer and ert, in evaluations / d.
    """
    figure, axes = _multiples(table, style.pens(optimizers), scaling, across=0.3)
    _span_times(axes, table["ert"])
    caption = (
        f"Expected running time / d to {target}, over the dimension d. A horizontal line grows in "
        "proportion to d; a point is missing where no trial reached the target."
    )
    data = table.pivot(index=["problem", "dimension"], columns="optimizer", values="ert")
    return Figure("scaling", caption, figure, table, data[list(optimizers)].rename_axis(columns=None))


def course_figure(stages: pd.DataFrame, pens: style.Pens) -> Figure:
    """Return the mean rank of each optimizer over the budget; ``stages`` are those of :func:`stage_ranks`.

    Over shares of the budget where the problems have different ones.
    """
    along = "evaluations" if (stages.groupby("share")["evaluations"].nunique() == 1).all() else "share"
    means = stages.groupby([along, "optimizer"], sort=False, observed=True)["rank"].mean().reset_index()
    problems = stages["problem"].nunique()
    caption = (
        f"Who leads when: the mean rank over {problems} problems after "
        f"{'some evaluations' if along == 'evaluations' else 'shares of the budget'}, 1 for the best."
    ).replace("over 1 problems", "on the only problem")
    return _ranks_along("ranks-over-budget", caption, means, along, pens, stages)


def stability_figure(stability: pd.DataFrame, pens: style.Pens) -> Figure:
    """Return the mean rank of each optimizer over the number of trials that count, with the range over subsets."""
    caption = (
        "Stability of the ranks: the mean rank over problems with only the first trials of each cell, 1 for the best; "
        "bands are the range over random subsets of as many trials. All bands end in a point, where subsets hold all "
        "trials; a curve that still moves there needs more of them."
    )
    return _ranks_along("stability", caption, stability, "trials", pens, stability)


def _ranks_along(
    name: str, caption: str, ranks: pd.DataFrame, along: str, pens: style.Pens, data: pd.DataFrame
) -> Figure:
    """Return the figure of the mean ranks along a column of ``ranks``; ``data`` are what its file holds."""
    named = [label for label, pen in pens.items() if not pen.background]
    right = style.text_width(style.names(named, RANK_NAME).values()) + 0.3
    figure, (ax,) = style.grid(1, width=_width(right), height=1.9, left=0.45, right=right, bottom=0.4, top=0.08)
    rank_course(ranks, pens=pens, ax=ax)
    shown = ranks.pivot(index=along, columns="optimizer", values="rank")[list(pens)].rename_axis(columns=None)
    return Figure(name, caption, figure, data, shown)


def rank_figure(mean_ranks: pd.Series[float], cliques: Collection[Sequence[str]]) -> Figure:
    """Return the critical-difference diagram of mean ranks over problems; a bar joins those of a clique."""
    side = style.text_width(style.names(mean_ranks.index, RANK_NAME).values()) + 0.5
    figure, (ax,) = style.grid(
        1, width=_width(2 * side),
        height=cd_height(mean_ranks.count(), len(cliques)), left=side, right=side, bottom=0.05, top=0.3,
    )  # fmt: skip
    cd_diagram(mean_ranks, cliques, ax=ax)
    caption = (
        "Critical-difference diagram: mean ranks over problems by the rivals beaten, the best at the left. A bar joins "
        "optimizers no pair of which differs significantly on these problems (Holm)."
    )
    return Figure("ranks", caption, figure, mean_ranks.rename_axis("optimizer").reset_index(name="mean_rank"))


def forest_figure(pairs: pd.DataFrame) -> Figure:
    """Return the probability of each pair to end lower over all problems, with its intervals and its test."""
    left = _left(forest_names(pairs))
    height = style.rows_height(len(pairs))
    figure, (ax,) = style.grid(1, width=_width(left), height=height, left=left, bottom=0.5, top=0.08)
    a12_forest(pairs, ax=ax)
    caption = (
        "The probability that a run of the first optimizer ends lower than one of the second, averaged over these "
        "problems, with 95% intervals that hold for all pairs together; thin: for further problems, one pair alone, "
        "if these are an independent sample of them. A point is filled where the test on these problems is significant "
        "(Holm). Dotted: the bounds of small, medium and large effects on both sides of 0.5."
    )
    return Figure("probability-to-end-lower", caption, figure, pairs)


def timing_figure(table: pd.DataFrame) -> Figure:
    """Return the mean time of one trial of each optimizer (thesis Fig. 7.5), split into objective and the rest."""
    shown = table.nsmallest(MOST_ROWS, "wall_mean") if len(table) > MOST_ROWS else table
    left = _left(style.names(shown["optimizer"]).values())
    figure, (ax,) = style.grid(1, width=_width(left), height=style.rows_height(len(shown)), left=left, top=0.25)
    timing(shown, ax=ax)
    data = table[["optimizer", "trials", "wall_mean", "objective_mean"]]
    some = f" The {len(shown)} fastest of {len(table)} are drawn." if len(shown) < len(table) else ""
    caption = f"Mean wall time of one trial of each optimizer over all problems.{some}"
    return Figure("mean-time", caption, figure, data)


def portfolio_figure(portfolio: Portfolio) -> Figure:
    """Return the score of each optimizer alone and of the best larger sets, beside that of the virtual best."""
    alone = portfolio.members.sort_values("score", ascending=False, kind="stable")[["optimizer", "score"]]
    sets = portfolio.sets[portfolio.sets["size"] > 1]
    drawn = alone[:MOST_ROWS]
    names = [*style.names(drawn["optimizer"]).values(), *(f"best set of {size}" for size in sets["size"])]
    best, left = float(portfolio.gap["virtual_score"].iloc[0]), _left(names)
    figure, (ax,) = style.grid(
        1, width=_width(left), height=style.rows_height(len(names)), left=left, right=0.5, bottom=0.45, top=0.08
    )
    shares(names, [*drawn["score"], *sets["score"]], [0] * len(drawn) + [1] * len(sets), best, ax=ax)
    which = (
        "each optimizer" if len(drawn) == len(alone) else f"each of the {len(drawn)} best of {len(alone)} optimizers"
    )
    larger = (
        ", and that of the best set found of each size up to the first within 5% of the virtual best"
        if len(sets)
        else ""
    )
    caption = f"The share of the targets that {which} reaches alone{larger}. Line: the virtual best, {best:.1%}."
    rows = [(optimizer, 1, score) for optimizer, score in alone.itertuples(index=False)]
    rows += [(" + ".join(members), size, score) for size, members, score, _ in sets.itertuples(index=False)]
    return Figure("portfolio-sets", caption, figure, pd.DataFrame(rows, columns=["optimizers", "size", "score"]))


def _multiples(
    frame: pd.DataFrame,
    pens: style.Pens,
    draw: Callable[..., Axes],
    *,
    across: float,
    down: float = 0.3,
    columns: int = COLUMNS,
) -> tuple[matplotlib.figure.Figure, list[Axes]]:
    """Draw a panel for each problem that has rows, axis labels at the edges only, and the legend above all."""
    problems = [problem for problem in labels(frame, "problem") if (frame["problem"] == problem).any()]
    width, height = (style.TEXT, 1.0) if columns == COLUMNS else (style.COLUMN, 1.2)
    height = 0.85 if len(problems) > 6 * columns else height  # all rows on one page
    figure, axes = style.grid(
        len(problems), columns=columns, width=width, height=height, left=0.6, across=across, down=down,
        top=_legend_height(pens, width) + down - 0.05,
    )  # fmt: skip
    for place, (problem, ax) in enumerate(zip(problems, axes, strict=True)):
        draw(frame, problem, pens=pens, legend=False, ax=ax)
        if place % columns:
            ax.set_ylabel("")
        if place + columns < len(problems):
            ax.set_xlabel("")
            ax.tick_params(labelbottom=False)
    style.legend_above(figure, style.handles(pens))
    return figure, axes


def _span_times(axes: Iterable[Axes], times: pd.Series[float]) -> None:
    """Give all axes the range of the finite running times, on a logarithmic scale."""
    finite = times.to_numpy(dtype=float)
    finite = finite[style.drawable(finite)]
    for ax in axes if len(finite) else ():
        ax.set_ylim(finite.min() / 2, 4 * finite.max())
        style.log_scale(ax, "y")


def _left(names: Iterable[str]) -> float:
    """Return the left margin in inches that the names of rows need."""
    return style.text_width(names, style.SMALL) + 0.12


def _width(margins: float) -> float:
    """Return the width of a column, or of the page where margins would leave less than two fifths of a column."""
    return style.COLUMN if margins < 0.6 * style.COLUMN else style.TEXT


def _legend_height(pens: style.Pens, width: float = style.TEXT) -> float:
    return style.legend_height([str(entry.get_label()) for entry in style.handles(pens)], width)


def _at_round_numbers(frame: pd.DataFrame, rows: list[str], value: str, multiples: tuple[int, ...]) -> pd.DataFrame:
    """Return ``value`` in a column per optimizer, at round numbers of the last of ``rows`` and at its largest.

    Round numbers are 0 and the ``multiples`` of powers of ten, or the next value below each; there are fewer of them
    where the table would be longer than :data:`SHOWN_ROWS`.
    """
    *groups, along = rows
    grid = np.unique(frame[along].to_numpy(dtype=float))
    positive = grid[grid > 0]
    parts = len(frame[groups].drop_duplicates()) if groups else 1
    for factors in (multiples, (1,), ()):
        decades = range(floor(log10(positive[0])), ceil(log10(positive[-1])) + 1) if len(positive) else ()
        marks = np.array([factor * 10.0**decade for decade in decades for factor in factors])
        at = positive[np.searchsorted(positive, marks[marks >= positive[:1]] * (1 + 1e-9), side="right") - 1]
        at = np.intersect1d(grid, [0.0, *at, *grid[-1:]])
        if len(at) * parts <= SHOWN_ROWS:
            break
    kept = frame[frame[along].isin(at)].astype(dict.fromkeys((*groups, "optimizer"), object))
    table = kept.pivot(index=rows, columns="optimizer", values=value)
    order = pd.MultiIndex.from_frame(kept[rows].drop_duplicates()) if groups else pd.Index(at, name=along)
    optimizers = labels(frame, "optimizer")
    return table.reindex(index=order, columns=optimizers).rename_axis(columns=None)
