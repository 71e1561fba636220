"""Anytime performance: convergence, targets reached, expected running time and success rates."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import ceil

import numpy as np
import pandas as pd

from bench import analysis
from bench.analysis.bands import profile_bands
from bench.analysis.compare import table as table_of
from bench.analysis.running_time import mean_shares
from bench.report.parts import Figure, File, Part, Section, Table
from bench.report.wording import count, leaders, listing
from bench.study.targets import Targets
from bench.topics.anytime import live
from bench.topics.anytime.figures import (
    convergence_figure,
    course_figure,
    ecdf_figure,
    ert_figure,
    figures_apart,
    regret_figure,
)
from bench.topics.anytime.leads import SAY, figure, sentences
from bench.topics.findings import Findings, Trials

TITLE = "Convergence and targets"


def section(findings: Findings) -> Section:
    """Return the anytime view: convergence, targets reached, expected running time and success rates."""
    if not findings.trials.traces:
        return Section(TITLE, ("No trial left a trace, so there is nothing to draw.",))
    budgets, dimensions, hits = findings.trials.budgets, findings.trials.dimensions, findings.anytime.hits
    budget = max(budgets.values())
    chosen = findings.anytime.target_set
    # Moré and Wild (2009): at 1e-1 to 1e-7. Of imported problems the dimension may be unknown.
    sizes = dimensions if dimensions.keys() >= {*findings.trials.problems} else None
    most = budget if sizes is None else max(ceil(budgets[label] / (1 + d)) for label, d in sizes.items())
    solved = profile_bands(hits, chosen.level, analysis.evaluation_grid(most), sizes)
    if chosen.restarts:
        reached = mean_shares(findings.anytime.restart_shares, findings.anytime.curves)
    elif not findings.trials.scaled:
        reached = analysis.ecdf(hits, analysis.evaluation_grid(budget))
    else:
        along = np.geomspace(1 / max(dimensions.values()), max(budgets[label] / d for label, d in dimensions.items()))
        reached = analysis.ecdf(hits, along, dimensions)
    together = ecdf_figure(
        reached,
        solved,
        findings.display.pens,
        target=chosen.at(chosen.level),
        ends=findings.anytime.ends(findings.trials.problems, per_dimension=findings.trials.scaled)
        if chosen.restarts
        else None,
        live=live.targets_reached(findings),
    )
    rates: list[Part] = [_success(findings.anytime.success, chosen), *_areas(findings)]
    text = (
        *_leaders(findings.trials, budget),
        *_fastest(findings),
        *sentences(findings),
        *_sets_agree(findings),
        *_ladder(chosen, findings.anytime.targets, len(findings.trials.problems)),
    )
    times = analysis.expected_running_time(hits)
    # A figure with a panel for each is a page or longer, and the problems of one dimension belong together.
    by_dimension: dict[int | None, list[str]] = {}
    for label in findings.trials.problems:
        by_dimension.setdefault(dimensions.get(label) if findings.trials.many else None, []).append(label)
    own_parts = tuple(
        Section(
            "Each problem" if dimension is None or len(by_dimension) == 1 else f"Each problem in dimension {dimension}",
            findings.display.drawn_words,
            tuple(_by_problem(findings, labels, times, suffix=f"-d{dimension}" if len(by_dimension) > 1 else "")),
            folded=True,
        )
        for dimension, labels in by_dimension.items()
    )
    every = [item for part in own_parts for item in part.items if isinstance(item, Figure)]
    apart = figures_apart(every, _functions(findings.trials), findings.display.drawn)
    return Section(
        TITLE,
        (*text, SAY("apart", apart[0].name, len(apart))) if apart else text,
        (*course(findings), *figure(findings), together, *rates),
        sections=own_parts,
        apart=tuple(apart),
    )


def _functions(trials: Trials) -> dict[str, str]:
    """Return the function of each problem, which several dimensions share; of no suite, the problem itself."""
    features = {label: trials.known[label].features for label in trials.problems}
    return {
        label: f"{own['suite']}-{own['function']}" if {"suite", "function"} <= set(own) else label
        for label, own in features.items()
    }


def _by_problem(findings: Findings, labels: Sequence[str], times: pd.DataFrame, suffix: str = "") -> Iterator[Figure]:
    """Yield the figures of convergence, regret and expected running time with a panel for each problem of ``labels``.

    A precision is a regret already, so that the convergence of pooled instances is their regret.
    """
    optimizers, unbeaten, frame = findings.display.drawn, findings.trials.unbeaten, findings.trials.frame
    frame, times = (table[table["optimizer"].isin(optimizers)] for table in (frame, times))
    grid = analysis.evaluation_grid(max(findings.trials.budgets[label] for label in labels))
    curves = analysis.convergence(frame[frame["problem"].isin(labels)], findings.trials.traces, grid)
    precisions = set(findings.trials.precisions) & unbeaten.keys()
    values = curves[~curves["problem"].isin(precisions)]
    if len(values):
        yield convergence_figure(values, optimizers, suffix)
    if findings.trials.shifts:
        measured = findings.trials.measured[findings.trials.measured["optimizer"].isin(optimizers)]
        curves = analysis.convergence(measured[measured["problem"].isin(labels)], findings.trials.measured_traces, grid)
    above = analysis.regret(curves, unbeaten, ("median", "q1", "q3"))
    if len(above):
        yield regret_figure(above, optimizers, suffix, precisions=findings.trials.precisions)
    yield ert_figure(times[times["problem"].isin(labels)], optimizers, suffix, chosen=findings.anytime.target_set)


def _leaders(trials: Trials, budget: int) -> list[str]:
    if len(trials.optimizers) < 2:
        return []
    stages = np.unique([max(round(share * budget), 1) for share in (0.01, 0.1, 1.0)])
    if not trials.scaled:
        curves = analysis.convergence(trials.frame, trials.traces, stages)
        return [
            " ".join(
                _lowest(part, count(int(str(spent)), "evaluation")) for spent, part in curves.groupby("evaluations")
            )
        ]
    shares, tables = (0.01, 0.1, 1.0), []  # of each problem's own budget
    for label, part in trials.frame.groupby("problem", observed=True, sort=False):
        spent = [max(round(share * trials.budgets[str(label)]), 1) for share in shares]
        reached = analysis.convergence(part, trials.traces, np.array(spent))
        tables.append(reached.assign(share=np.tile(shares, len(reached) // len(shares))))
    return [" ".join(_lowest(part, f"{share:.0%} of the budget") for share, part in pd.concat(tables).groupby("share"))]


def _lowest(reached: pd.DataFrame, spent: str) -> str:
    """Return the optimizers with the lowest median after ``spent`` evaluations, and the number of problems of each."""
    median = table_of(reached, "median")
    finite = median.where(np.isfinite(median.to_numpy(dtype=float)))
    return f"After {spent} {leaders(finite.eq(finite.min(axis=1), axis=0), 'the lowest median')}."


def _fastest(findings: Findings) -> list[str]:
    """Return the optimizers with the lowest ERT in evaluations and in seconds, where there are several optimizers."""
    chosen, table = findings.anytime.target_set, findings.anytime.running_times
    solved = table.loc[table["successes"] > 0, chosen.unit].unique().tolist()
    level = chosen.level if chosen.level in solved else min(solved, default=np.nan)
    at_level = table[table[chosen.unit] == level]
    reached = [table_of(at_level, name).astype(float) for name in ("ert", "ert_s")] if len(at_level) else []
    lowest = [of_share.eq(of_share.min(axis=1), axis=0) & np.isfinite(of_share) for of_share in reached]
    if len(findings.trials.optimizers) < 2 or not any(of_share.any(axis=None) for of_share in lowest[:1]):
        return []
    sentence = f"To {chosen.at(level)}, {leaders(lowest[0], 'the lowest expected running time in evaluations')}"
    if lowest[1].any(axis=None):
        sentence += f"; in seconds of wall time, {leaders(lowest[1], 'the lowest')}"
    return [f"{sentence}."]


def _sets_agree(findings: Findings) -> list[str]:
    """Return whether the choice of targets changes the order of the optimizers."""
    sets = findings.anytime.target_sets
    sets = sets[sets.groupby("set")["area"].transform("max") > 0]  # where nothing is reached, there is no order
    ranks = sets.pivot(index="optimizer", columns="set", values="rank").reindex(
        columns=list(dict.fromkeys(sets["set"]))
    )
    ranks = ranks.dropna(axis=1, how="any").reindex(
        [optimizer for optimizer in findings.trials.optimizers if optimizer in ranks.index]
    )
    if len(ranks) < 2 or ranks.shape[1] < 2:
        return []
    shown = f"{count(ranks.shape[1], 'set')} of targets ({listing(list(map(str, ranks.columns)))})"
    if ranks.eq(ranks.iloc[:, 0], axis=0).all(axis=None):
        return [f"The choice of targets does not matter here: the order of the optimizers is the same under {shown}."]
    first: dict[str, list[str]] = {}
    for name, rank_of in ranks.items():
        first.setdefault(listing(list(map(str, rank_of.index[rank_of == rank_of.min()])), 4), []).append(str(name))
    if len(first) == 1:
        who = next(iter(first))
        return [f"Under {shown} the first is the same, {who}, but the order of the others depends on the choice."]
    parts = [f"{who} under {listing(names)}" for who, names in first.items()]
    return [f"The choice of targets matters: of {shown}, the first is {'; '.join(parts)}."]


def _areas(findings: Findings) -> list[Table]:
    """Return the tables of the areas under the ECDF of three sets of targets, and of AOCC."""
    sets = findings.anytime.target_sets
    tables = []
    names = list(dict.fromkeys(sets["set"]))
    if len(sets) and len(findings.trials.optimizers) > 1:
        wide = {
            f"{name}: {column}": sets[sets["set"] == name].set_index("optimizer")[column]
            for name in names
            for column in ("area", "rank")
        }
        shown = pd.DataFrame(wide).reindex(findings.trials.optimizers).rename_axis("optimizer")
        best = pd.DataFrame(
            {name: table.eq(table.min()) for name, table in shown.items() if str(name).endswith("rank")}
        )
        tables.append(
            Table(
                "target-sets",
                "The mean area under the runtime distribution over log evaluations, and the rank by it, under each set "
                "of targets.",
                shown,
                bold=best,
                decimals={str(name): 1 if str(name).endswith("rank") else 3 for name in shown},
                note="An area of 1: every target with the first evaluation; 0: none within the budget. Problems on "
                "which an optimizer has no trial do not count. Bold: the first.",
                data=sets,
            )
        )
    if findings.anytime.target_set.absolute and len(table := findings.anytime.aocc):
        mean = table.groupby("optimizer")[["aocc", "aocc_from_zero"]].mean()
        problems = table["problem"].nunique()
        tables.append(
            Table(
                "aocc",
                f"The area over the convergence curve (AOCC), the mean over {count(problems, 'problem')} with a known "
                "optimum.",
                mean[["aocc"]]
                .rename(columns={"aocc": "AOCC"})
                .reindex(findings.trials.optimizers)
                .rename_axis("optimizer"),
                decimals=4,
                note="van Stein et al. (2024): the mean over the evaluations of the budget of 1 − (log10 y + 8) / 10, "
                "where y is the best precision so far, between 1e-8 and 1e2; 1 is best. In the CSV file, "
                "aocc_from_zero is the integral that iohinspector computes.",
                data=table,
            )
        )
    return tables


def _ladder(chosen: Targets, targets: pd.DataFrame, problems: int) -> list[str]:
    optimum_known = targets.drop_duplicates("problem")["known"].astype(bool)
    text = (
        f"{chosen.meaning(optimum_known.tolist())} The expected "
        "running time (ERT) is the number of evaluations that all trials spent until they reached the target or ended, "
        "divided by the number of successes; it is infinite where no trial succeeds."
    )
    if chosen.restarts:
        text += (
            " Shares of targets reached are those of simulated restarts: trials are drawn with replacement until a "
            "successful one, and their evaluations added, so curves go on beyond the budget."
        )
    if len(optimum_known) == problems:
        return [text]
    without = f"{count(problems - len(optimum_known), 'problem')} {chosen.without}"
    return [text, f"The figures below leave out {without}: there are no targets."]


def _success(rates: pd.DataFrame, chosen: Targets) -> Table:
    overall = rates.groupby(["optimizer", "tau"], sort=False, observed=True)[["successes", "trials"]].sum()
    share = 100 * overall["successes"] / overall["trials"].where(overall["trials"] > 0)
    wide = share.unstack().sort_index(axis=1, ascending=False).rename_axis(columns=None)
    wide = wide.loc[share.index.unique("optimizer")]  # unstack(sort=False) of pandas 2.2 mixes up the values
    return Table(
        "success-rates",
        f"Percentage of trials over all problems that reached a target, by {chosen.unit}.",
        wide.rename(columns=chosen.at),
        decimals=1,
        note="The CSV file and the sections below have the rates by problem, with 95% Wilson intervals.",
        data=chosen.in_unit(rates),
    )


def course(findings: Findings) -> list[Figure]:
    """Return the figure of the ranks over the budget, none without a trace."""
    return (
        [course_figure(findings.anytime.stages, findings.display.pens)]
        if findings.trials.traces and findings.anytime.stages["share"].nunique() > 1
        else []
    )


def tables(findings: Findings) -> list[File]:
    """Return the running times of every target, where any trial left a trace."""
    targets = findings.anytime.target_set
    frame = targets.in_unit(findings.anytime.running_times, targets.unit)
    about = "The expected running times (ERT) of every optimizer on every problem, with their spread."
    return [File("tables/running-times.csv", about, frame)] if len(frame) else []
