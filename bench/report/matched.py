"""The conditions that differ, the leader against its rivals under the same ones, and what controls would cost."""

from __future__ import annotations

import math

import pandas as pd

from bench import analysis
from bench._helpers.console import duration
from bench.analysis.cells import complete_problems
from bench.execution.matched import algorithms
from bench.optimizer import CONDITIONS
from bench.plugins import registry
from bench.report.conditions import MOST_LABELS, by_value, conditions, grouped
from bench.report.findings import Findings
from bench.report.wording import count, listing, options

REPORTED = "as reported"
UNUSED = 0.01  # of the budget, on average, that an optimizer may leave as others do
RIVALS = 5
"""The rivals of the leader that are compared, the best by mean rank."""

COLUMNS = ("conditions", "rival", "first", "second", "problems", "probability", "low", "high")


def differing(findings: Findings) -> str:
    """Return what differs between the optimizers besides their algorithms as a clause; "" where nothing is known to.

    That is :func:`options_differing`, and the share of the budget that an optimizer used. Such as ``"handling and start
    are box, midpoint for cma-es and repair, random for the 4 others, cma-es stopped after 72% of the budget"``. An
    optimizer without an option, such as a search without a population, does not differ in it.
    """
    spent = 1 - findings.anytime.unused.set_index("optimizer")["unused"].astype(float)
    early = [f"{label} stopped after {share:.0%}" for label, share in spent[spent < 1 - UNUSED].sort_values().items()]
    stopped = f"{listing(early, at_most=MOST_LABELS)} of the budget" if early else ""
    return ", ".join(filter(None, (options_differing(findings), stopped)))


def options_differing(findings: Findings) -> str:
    """Return which conditions differ by the options of the optimizers as a clause; "" where none is known to."""
    table = conditions(findings.study, findings.descriptions)
    alike: dict[tuple[tuple[str, ...], ...], dict[str, list[str]]] = {}  # conditions and values, by who has the same
    set_here = {name for entry in findings.study.optimizers for name in entry.options}
    for name in CONDITIONS:
        groups = by_value(table[name].dropna())
        # The population that an algorithm takes of its own accord is a part of it.
        if len(groups) > 1 and (name != "agents" or name in set_here):
            alike.setdefault(tuple(map(tuple, groups.values())), {})[name] = [*groups]
    clauses = []
    for owners, values in alike.items():
        together = {", ".join(own): [*labels] for *own, labels in zip(*values.values(), owners, strict=True)}
        clauses.append(f"{listing([*values])} {'is' if len(values) == 1 else 'are'} {grouped(together)}")
    return ", ".join(clauses)


def chances(findings: Findings) -> pd.DataFrame:
    """Return the probability that a run of the leader beats one of each rival, as reported and under each condition.

    One row a condition and rival, with the columns ``COLUMNS``: ``first`` and ``second`` are the labels of the
    optimizers or controls whose runs are compared, ``probability`` is the mean over problems of A12 with its 95 %
    interval. Conditions are left out under which the leader has no trials.
    """
    kinds, ranked = algorithms(findings.results.study), findings.final.ranked
    if not len(findings.final.medians):
        return pd.DataFrame(columns=list(COLUMNS))
    leader = ranked[0]
    best = {kind: label for label in reversed(ranked) if (kind := kinds[label]) != kinds[leader]}  # of each algorithm
    rivals = sorted(best.values(), key=ranked.index)[:RIVALS]
    rows = [(REPORTED, rival, *_row(findings, leader, rival)) for rival in rivals]
    for each in findings.matched:
        name = options(each.values)
        for rival in rivals:
            pair = [each.entries[kinds[label]].label for label in (leader, rival) if kinds[label] in each.entries]
            if len(pair) == 2 and (row := _row(findings, *pair))[2]:
                rows.append((name, rival, *row))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _row(findings: Findings, first: str, second: str) -> tuple[str, str, int, float, float, float]:
    """Return first, second, problems, probability, low and high of two optimizers or controls."""
    problems = list(findings.final.medians.index)
    own = pd.concat([frame for frame in (findings.trials.frame, findings.trials.controls) if len(frame)])
    own = own[own["optimizer"].isin([first, second]) & own["problem"].isin(problems)]
    own = own.assign(
        problem=pd.Categorical(own["problem"].astype(object), problems),
        optimizer=pd.Categorical(own["optimizer"].astype(object), [first, second]),
    )
    if not complete_problems(own):
        return first, second, 0, math.nan, math.nan, math.nan
    found = analysis.probability_of_improvement(analysis.pairwise_tests(own)).iloc[0]
    return first, second, *(found[name] for name in COLUMNS[4:])


def cost(findings: Findings) -> str:
    """Return what the missing controls would cost as a clause; "" where no control is missing.

    Such as ``"matched controls (bench run thesis --matched) would add 2,700 trials, about 4 min on 2 jobs"``. The time
    is the mean of the trials that each algorithm has made, and the number of jobs that of the last run.
    """
    study, frame = findings.results.study, findings.results.frame
    made = findings.results.controls["optimizer"].value_counts()
    compared = {entry.label for entry in study.optimizers}
    controls = {
        entry.label: kind
        for each in findings.matched
        for kind, entry in each.entries.items()
        if entry.label not in compared
    }
    lacking = {label: len(study.problems) * study.trials - int(made.get(label, 0)) for label in controls}
    total = sum(lacking.values())
    if not total:
        return ""
    kinds = frame["optimizer"].astype(object).map(algorithms(study))
    mean = pd.to_numeric(frame["wall_s"], errors="coerce").astype(float).groupby(kinds).mean()
    jobs = next((n for each in reversed(findings.results.environments) if isinstance(n := each.get("jobs"), int)), 1)
    seconds = sum(number * mean.get(controls[label], math.nan) for label, number in lacking.items())
    time = "" if math.isnan(seconds) else f", about {duration(seconds / jobs)} on {count(jobs, 'job')}"
    name = study.name if study.name in registry.entries("studies") else "STUDY"
    return f"matched controls (bench run {name} --matched) would add {count(total, 'trial')}{time}"
