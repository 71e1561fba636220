"""Anytime performance: convergence, targets reached, expected running time and success rates."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import ceil

import numpy as np
import pandas as pd

from bench import analysis
from bench.report.findings import Findings
from bench.report.parts import Figure, Section, Table
from bench.report.plots import convergence_figure, ecdf_figure, ert_figure, regret_figure
from bench.report.wording import count, leaders

TITLE = "Convergence and targets"
PROFILE = 1e-2  # Moré and Wild (2009) draw data profiles at 1e-1 to 1e-7; here the middle of the ladder


def section(findings: Findings) -> Section:
    """Return the anytime view: convergence, targets reached, expected running time and success rates."""
    if not findings.traces:
        return Section(TITLE, ("No trial left a trace, so there is nothing to draw.",))
    budgets, dimensions, hits = findings.budgets, findings.dimensions, findings.hits
    budget = max(budgets.values())
    groups = analysis.evaluation_grid(max(ceil(budgets[label] / (1 + d)) for label, d in dimensions.items()))
    profiles = analysis.data_profiles(hits, PROFILE, groups, dimensions)
    reached = analysis.ecdf(hits, analysis.evaluation_grid(budget))
    if findings.scaled:
        along = np.geomspace(1 / max(dimensions.values()), max(budgets[label] / d for label, d in dimensions.items()))
        reached = analysis.ecdf(hits, along, dimensions)
    together = ecdf_figure(reached, profiles, findings.optimizers, tau=PROFILE)
    rates = _success(findings.success)
    text = (*_leaders(findings, budget), *_ladder(findings.targets, len(findings.problems)))
    times = analysis.expected_running_time(hits)
    if not findings.many:
        *values, running = _by_problem(findings, findings.problems, times)
        return Section(TITLE, text, (*values, together, running, rates))
    # A figure of so many panels is longer than a page, and the problems of one dimension belong together.
    by_dimension: dict[int | None, list[str]] = {}
    for label in findings.problems:
        by_dimension.setdefault(dimensions.get(label), []).append(label)
    own_parts = tuple(
        Section(
            "Each problem" if dimension is None or len(by_dimension) == 1 else f"Each problem in dimension {dimension}",
            items=tuple(_by_problem(findings, labels, times, suffix=f"-d{dimension}" if len(by_dimension) > 1 else "")),
            folded=True,
        )
        for dimension, labels in by_dimension.items()
    )
    return Section(TITLE, text, (together, rates), sections=own_parts)


def _by_problem(findings: Findings, labels: Sequence[str], times: pd.DataFrame, suffix: str = "") -> Iterator[Figure]:
    """Yield the figures of convergence, regret and expected running time with a panel for each problem of ``labels``.

    A precision is a regret already, so that the convergence of pooled instances is their regret.
    """
    optimizers, unbeaten, frame = findings.optimizers, findings.unbeaten, findings.frame
    grid = analysis.evaluation_grid(max(findings.budgets[label] for label in labels))
    curves = analysis.convergence(frame[frame["problem"].isin(labels)], findings.traces, grid)
    precisions = set(findings.pooled.functions) & unbeaten.keys()
    values = curves[~curves["problem"].isin(precisions)]
    if len(values):
        yield convergence_figure(values, optimizers, suffix)
    above = analysis.regret(curves, unbeaten, ("median", "q1", "q3"))
    if len(above):
        yield regret_figure(above, optimizers, suffix)
    yield ert_figure(times[times["problem"].isin(labels)], optimizers, suffix)


def _leaders(findings: Findings, budget: int) -> list[str]:
    if len(findings.optimizers) < 2:
        return []
    stages = np.unique([max(round(share * budget), 1) for share in (0.01, 0.1, 1.0)])
    if not findings.scaled:
        curves = analysis.convergence(findings.frame, findings.traces, stages)
        return [
            " ".join(_lowest(own, count(int(str(spent)), "evaluation")) for spent, own in curves.groupby("evaluations"))
        ]
    sentences = []
    for share in (0.01, 0.1, 1.0):  # of each problem's own budget
        each = []
        for label, own in findings.frame.groupby("problem", observed=True, sort=False):
            spent = np.array([max(round(share * findings.budgets[str(label)]), 1)])
            each.append(analysis.convergence(own, findings.traces, spent))
        sentences.append(_lowest(pd.concat(each), f"{share:.0%} of the budget"))
    return [" ".join(sentences)]


def _lowest(reached: pd.DataFrame, spent: str) -> str:
    """Return which optimizers had the lowest median of how many problems after the evaluations ``spent``."""
    median = analysis.table(reached, "median")
    finite = median.where(np.isfinite(median.to_numpy(dtype=float)))
    return f"After {spent} {leaders(finite.eq(finite.min(axis=1), axis=0), 'the lowest median')}."


def _ladder(targets: pd.DataFrame, problems: int) -> list[str]:
    known = targets.drop_duplicates("problem")["known"].astype(bool)
    deep, short = (f"{analysis.fractions(each)[-1]:g}" for each in (True, False))
    reference, last = (
        ("the known optimum", deep)
        if known.all()
        else ("the lowest value that any trial found (every optimum is unknown or beaten)", short)
        if not known.any()
        else (
            "the known optimum, or the lowest value found where the optimum is unknown or beaten",
            f"{deep} where f_L is the optimum, else to {short}",
        )
    )
    meaning = (
        "A target is the objective value f_L + tau (f_0 − f_L), where f_0 is the median of the first values of the "
        f"trials and f_L is {reference} (Moré and Wild 2009). Targets fall from tau = 1 to {last}. The expected "
        "running time (ERT) is the number of evaluations that all trials spent until they reached the target or ended, "
        "divided by the number of successes; it is infinite where no trial succeeds."
    )
    if len(known) == problems:
        return [meaning]
    without = count(problems - len(known), "problem")
    return [
        meaning,
        f"The figures below leave out {without} on which no trial found a finite value: there are no targets.",
    ]


def _success(rates: pd.DataFrame) -> Table:
    overall = rates.groupby(["optimizer", "tau"], sort=False, observed=True)[["successes", "trials"]].sum()
    share = 100 * overall["successes"] / overall["trials"].where(overall["trials"] > 0)
    wide = share.unstack(sort=False).sort_index(axis=1, ascending=False).rename_axis(columns=None)
    return Table(
        "success-rates",
        "Percentage of trials over all problems that reached a target, by tau.",
        wide.rename(columns=lambda tau: f"tau = {tau:g}"),
        decimals=1,
        note="The CSV file and the sections below have the rates by problem, with 95% Wilson intervals.",
        data=rates,
    )
