"""Anytime performance: convergence, targets reached, expected running time and success rates."""

from __future__ import annotations

from math import ceil

import numpy as np
import pandas as pd

from bench import analysis
from bench.report.findings import Findings
from bench.report.parts import Part, Section, Table
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
    grid = analysis.evaluation_grid(budget)
    groups = analysis.evaluation_grid(max(ceil(budgets[label] / (1 + d)) for label, d in dimensions.items()))
    profiles = analysis.data_profiles(hits, PROFILE, groups, dimensions)
    reached = analysis.ecdf(hits, grid)
    if findings.scaled:
        along = np.geomspace(1 / max(dimensions.values()), max(budgets[label] / d for label, d in dimensions.items()))
        reached = analysis.ecdf(hits, along, dimensions)
    curves = analysis.convergence(findings.frame, findings.traces, grid)
    above = analysis.regret(curves, findings.unbeaten, ("median", "q1", "q3"))
    items: tuple[Part, ...] = (
        convergence_figure(curves, findings.optimizers),
        *([regret_figure(above, findings.optimizers)] if len(above) else []),
        ecdf_figure(reached, profiles, findings.optimizers, tau=PROFILE),
        ert_figure(analysis.expected_running_time(hits), findings.optimizers),
        _success(findings.success),
    )
    text = (*_leaders(findings, budget), *_ladder(findings.targets, len(findings.problems)))
    return Section(TITLE, text, items)


def _leaders(findings: Findings, budget: int) -> list[str]:
    if len(findings.optimizers) < 2:
        return []
    stages = np.unique([max(round(share * budget), 1) for share in (0.01, 0.1, 1.0)])
    curves = analysis.convergence(findings.frame, findings.traces, stages)
    sentences = []
    for spent, reached in curves.groupby("evaluations"):
        median = analysis.table(reached, "median")
        finite = median.where(np.isfinite(median.to_numpy(dtype=float)))
        lowest = leaders(finite.eq(finite.min(axis=1), axis=0), "the lowest median")
        sentences.append(f"After {count(int(str(spent)), 'evaluation')} {lowest}.")
    return [" ".join(sentences)]


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
