"""Draw the progress over the evaluations: curves, running times, targets and ranks."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from bench.analysis.cells import NEAR
from bench.analysis.instances import SOLVED
from bench.plots import convergence, data_profile, ecdf, ert, regret, style
from bench.plots.curves import MOST_BANDS
from bench.report.parts import Figure
from bench.study.targets import KINDS, Targets
from bench.topics.figures import (
    COLUMNS,
    at_round_numbers,
    beside_best,
    ended,
    legend_height,
    panels,
    ranks_along,
    span_times,
)


def convergence_figure(curves: pd.DataFrame, optimizers: Iterable[str], suffix: str = "") -> Figure:
    """Return the median best-so-far value over evaluations with its quartiles, a panel a problem.

    ``suffix`` ends the figure's name, where there are several of the kind.
    """
    caption = (
        f"Median best-so-far objective value over evaluations{_banded(optimizers)} (log axes where the "
        "values are positive and wide). A trial that ended early keeps its last value; failed trials count as infinite."
    )
    return over_evaluations(f"convergence{suffix}", caption, convergence, curves, optimizers)


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
    return over_evaluations(f"regret-curves{suffix}", caption, regret, curves, optimizers)


def _banded(optimizers: Iterable[str]) -> str:
    return ", with the quartiles as a band" if len(list(optimizers)) <= MOST_BANDS else ""


def figures_apart(shown: Sequence[Figure], functions: Mapping[str, str], optimizers: Iterable[str]) -> list[Figure]:
    """Return a figure of each of several functions: the regret where it is known, else the values, a panel a problem.

    ``shown`` are the figures of :func:`convergence_figure` and :func:`regret_figure`, whose curves are drawn again;
    ``functions`` has the function of each problem.
    """
    problems: dict[str, list[str]] = {}
    for label, function in functions.items():
        problems.setdefault(function, []).append(label)
    kinds = (("regret-curves", "regret", regret), ("convergence", "best objective value", convergence))
    figures = []
    for function, labels in problems.items() if len(problems) > 1 else ():
        for kind, what, draw in kinds:
            drawn = [figure.data for figure in shown if figure.name.startswith(kind)]
            curves = [table[table["problem"].isin(labels)] for table in drawn]
            if sum(table["problem"].nunique() for table in curves) == len(labels):
                caption = f"Convergence on {function}: the median {what} over evaluations{_banded(optimizers)}."
                columns = COLUMNS if len(labels) > 1 else 1
                name = f"convergence-{function}"
                figures.append(over_evaluations(name, caption, draw, pd.concat(curves), optimizers, columns))
                break
    return figures


def over_evaluations(
    name: str,
    caption: str,
    draw: Callable[..., Axes],
    curves: pd.DataFrame,
    optimizers: Iterable[str],
    columns: int = COLUMNS,
) -> Figure:
    """Return a figure of curves over evaluations, a panel a problem, each drawn by ``draw``."""
    figure, axes = panels(curves, style.pens(optimizers), draw, across=0.46, columns=columns)
    for ax in axes:
        style.span(ax, curves["evaluations"])
    shown = at_round_numbers(curves, ["problem", "evaluations"], "median", (1, 2, 5))
    return Figure(name, caption, figure, curves, shown)


def ert_figure(
    table: pd.DataFrame, optimizers: Iterable[str], suffix: str = "", *, chosen: Targets = KINDS["relative"]
) -> Figure:
    """Return the expected running time over targets, a panel a problem, all on the same axes.

    ``suffix`` ends the figure's name, where there are several of the kind.
    """
    figure, axes = panels(table, style.pens(optimizers), ert, across=0.12)
    for ax in axes:
        if chosen.unit != "tau" and ax.get_xlabel():
            ax.set_xlabel(chosen.unit)
    drawn = table[table["tau"] > 0]
    for place, ax in enumerate(axes):
        if len(drawn):
            ax.set_xlim(1.2 * drawn["tau"].max(), drawn["tau"].min() / 1.2)
            style.log_scale(ax, "x")
        if chosen.rising:
            ax.set_xticks(chosen.tabled, [chosen.level_text(tau) for tau in chosen.tabled], minor=False)
        ax.tick_params(labelleft=place % COLUMNS == 0)
    span_times(axes, drawn["ert"])
    caption = (
        "Expected running time (ERT) over targets, harder ones to the right. A curve ends at the hardest target that "
        "any trial reached, in an open marker where no trial reached the harder ones."
    )
    if set(table["problem"]) > set(drawn["problem"]):
        caption += " A panel is empty where the trials start at the reference, which is then the only target (tau = 0)."
    table = chosen.in_unit(table)
    by_target = at_round_numbers(table, ["problem", "tau"], "ert", (1,))
    return Figure(f"expected-running-time{suffix}", caption, figure, table, by_target)


def ecdf_figure(
    reached: pd.DataFrame,
    profile: pd.DataFrame,
    optimizers: Iterable[str],
    *,
    target: str,
    ends: Mapping[str, float] | None = None,
    live: Mapping[str, Any] | None = None,
) -> Figure:
    """Return two panels over evaluations: the share of targets reached, and the data profile at a ``target``.

    ``ends`` are the budgets, where ``reached`` are shares of simulated restarts; these may have the best of 2009.
    ``profile`` may have bands; ``live`` is the same figure for readers with scripts (:mod:`bench.topics.anytime.live`).
    """
    pens = beside_best(reached, optimizers)
    figure, (left, right) = style.grid(2, height=1.8, left=0.5, across=0.55, top=legend_height(pens) + 0.1)
    data_profile(profile, pens=pens, legend=False, ax=right)
    ecdf(reached, pens=pens, legend=False, ax=left, ends=ends)
    style.legend_above(figure, style.handles(pens))
    along = "groups" if "groups" in profile else "evaluations"
    over = "per_dimension" if "per_dimension" in reached else "evaluations"
    banded = ", with 95% bands that hold at all budgets together, for new runs on these problems"
    banded = banded if "low" in profile and profile["low"].notna().any() and len(pens) <= MOST_BANDS else ""
    unit = ", over groups of d + 1 evaluations" if along == "groups" else ""
    caption = (
        f"Left: the share of all targets, of all problems and {'simulated restarts' if ends else 'trials'}, that "
        f"was reached, over evaluations{' / d' if over == 'per_dimension' else ''}.{ended(ends)} Right: the data "
        f"profile at {target}, the share of all trials that reached this one target{unit}{banded}."
    )
    panels = {"targets reached": (reached, over), "data profile": (profile, along)}
    data = pd.concat([frame.assign(panel=name) for name, (frame, _) in panels.items()], ignore_index=True)
    shown = pd.concat(
        {name: at_round_numbers(frame, [by], "fraction", (1, 2, 5)) for name, (frame, by) in panels.items()},
        names=["panel", "evaluations" if along == over else "evaluations or groups"],
    )
    return Figure("targets-reached", caption, figure, data, shown, live)


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
    return ranks_along("ranks-over-budget", caption, means, along, pens, stages)
