"""A suite at a glance: ranks and targets reached by group of functions and dimension, and how running times scale."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from bench import analysis
from bench.analysis.compare import table as table_of
from bench.analysis.instances import SOLVED
from bench.analysis.running_time import mean_shares
from bench.report.parts import Figure, Part, Section, Table
from bench.report.wording import count, listing
from bench.topics.findings import BEST, Anytime, Findings, Trials
from bench.topics.suite.ert_table import ert_table
from bench.topics.suite.figures import reached_figure, scaling_figure, scatter_figure

TITLE = "The suite at a glance"
ALL = "all functions"
Panels = dict[str, list[str]]  # the problems of each panel, by its title
SAME_SHARE = 5e-4  # of the targets: shares closer than this are printed alike


def section(findings: Findings) -> Section | None:
    """Return the overview of a study whose problems are functions of groups, in dimensions; None for any other."""
    members = _members(findings.trials)
    if (
        len(findings.trials.optimizers) < 2
        or members.empty
        or len(members[["group", "dimension"]].drop_duplicates()) < 2
    ):
        return None
    ranks = _ranks(findings, members)
    text, chosen = [_meaning(findings.trials, members)], findings.anytime.target_set
    if not findings.trials.traces:
        return Section(TITLE, (*text, *findings.display.drawn_words), (ranks,))
    reached = _reached(findings, _panels(members))
    if reached.empty:
        return Section(TITLE, ("No trial has a target.", *text, *findings.display.drawn_words), (ranks,))
    items: list[Part] = [
        *_overview(findings, members),
        _figure(findings, "targets-by-group", reached, _panels(members)),
        ranks,
    ]
    if members.groupby("function")["dimension"].nunique().max() > 1:
        scaled = _scaling(findings.anytime, members)
        items.append(scaling_figure(scaled, findings.display.drawn, target=chosen.at(chosen.level)))
    items += _scatter(findings, members)
    most = max(findings.trials.budgets[label] / d for label, d in findings.trials.dimensions.items())
    within = reached[(reached["per_dimension"] <= most * (1 + 1e-9)) & (reached["optimizer"] != BEST)]
    text = [_most_targets(within), *text, *findings.display.drawn_words]
    return Section(TITLE, tuple(text), tuple(items), sections=tuple(_each_dimension(findings, members)))


def _overview(findings: Findings, members: pd.DataFrame) -> list[Figure]:
    """Return the share of targets reached of all functions, a panel a dimension; none where problems are left out."""
    if len(members) != len(findings.trials.problems):
        return []
    panels = {
        _title(ALL, int(str(dimension))): list(rows["problem"])
        for dimension, rows in members.groupby("dimension", sort=True)
    }
    reached = _reached(findings, panels)
    return [_figure(findings, "targets-of-all", reached, panels, columns=min(len(panels), 2))]


def _figure(findings: Findings, name: str, reached: pd.DataFrame, panels: Panels, columns: int = 0) -> Figure:
    """Return the figure of curves of :func:`_reached`, on ``columns`` columns of panels within one of a paper."""
    anytime, drawn = findings.anytime, findings.display.drawn
    ends = {title: anytime.ends(problems, per_dimension=True) for title, problems in panels.items()}
    shown = reached[reached["optimizer"].isin([*drawn, BEST])]
    kwargs = {"columns": columns} if columns else {}
    single = all(len(problems) == 1 for problems in panels.values())
    what = "dimension" if columns else "function" if single else "group"
    return reached_figure(name, shown, drawn, ends=ends if anytime.target_set.restarts else None, what=what, **kwargs)


def _each_dimension(findings: Findings, members: pd.DataFrame) -> Iterator[Section]:
    """Yield the functions of each dimension: the targets reached on each, and their running times in one table."""
    for dimension, rows in members.groupby("dimension", sort=True):
        d, parts = int(str(dimension)), rows["function"].str.partition(" ")
        functions = parts[2] if parts[0].nunique() == 1 and parts[2].all() else rows["function"]
        names = dict(zip(rows["problem"], functions if functions.is_unique else rows["problem"], strict=True))
        panels = {_title(name, d): [problem] for problem, name in names.items()}
        items: list[Part] = []
        reached = _reached(findings, panels)
        if len(reached):
            items.append(_figure(findings, f"targets-by-function-d{d}", reached, panels))
        if len(findings.anytime.running_times):
            items.append(ert_table(findings, names, d))
        yield Section(f"Function by function in dimension {d}", (), tuple(items), folded=True)


def _scatter(findings: Findings, members: pd.DataFrame) -> list[Figure]:
    """Return the running times of the first two in rank, or of the subject and the first other one."""
    first = findings.leader
    second = next(label for label in findings.final.ranked if label != first)
    unit, times = findings.anytime.target_set.unit, findings.anytime.running_times
    rows = times[times["problem"].isin(members["problem"])]
    wide = rows.pivot(index=["problem", unit], columns="optimizer", values="ert_per_d").astype(float)
    wide = wide.reindex(columns=[first, second]).dropna()
    if not np.isfinite(wide).any(axis=None):
        return []
    table = wide.reset_index().rename_axis(columns=None)
    dimension = table["problem"].map(members.set_index("problem")["dimension"])
    table = table.assign(kind="d = " + dimension.astype(str)).iloc[dimension.argsort(kind="stable")]
    return [scatter_figure(findings.anytime.target_set.in_unit(table, unit), first, second)]


def _members(trials: Trials) -> pd.DataFrame:
    """Return problem, function, group and dimension of the problems that have all of these features."""
    rows = [
        (label, f"{facts.features.get('suite', '')} {facts.features.get('function', label)}".strip(),
         str(facts.features["group"]), trials.dimensions[label])
        for label, facts in trials.known.items()
        if "group" in facts.features and label in trials.dimensions
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=["problem", "function", "group", "dimension"])


def _meaning(trials: Trials, members: pd.DataFrame) -> str:
    functions, dimensions = members["function"].nunique(), sorted(members["dimension"].unique())
    shown = listing([f"{dimension:g}" for dimension in dimensions])
    text = (
        f"{count(functions, 'function')} in {count(members['group'].nunique(), 'group')}, in "
        f"{'dimensions' if len(dimensions) > 1 else 'dimension'} {shown}. A problem is a function in one dimension."
    )
    pools = [instances for instances in trials.pooled.members.values() if len(instances) > 1]
    if pools:
        pooled = f"instances ({listing(sorted({f'{len(instances)}' for instances in pools}, key=int))} each)"
        some = len(pools) < len(members)
        text += (
            f" {f'On {len(pools)} of {len(members)} problems, the' if some else 'Its'} {pooled} are pooled, as COCO "
            f"does: all their trials are trials of the problem, and {'the' if some else 'its'} values are precisions, "
            f"the best objective value less the optimum of the instance, taken as 0 from {SOLVED:g} on."
            + (" The values of the others are objective values." if some else "")
            + (" Trials are compared within each instance." if trials.stratified else "")
        )
    return text


def _title(group: str, dimension: int) -> str:
    return f"{group}, d = {dimension}"


def _panels(members: pd.DataFrame) -> Panels:
    """Return the problems of each panel by its title: first all functions, then each group, by dimension."""
    panels: dict[tuple[str, int], list[str]] = {}
    groups = list(dict.fromkeys(members["group"]))
    for member in members.itertuples(index=False):
        for group in (ALL, member.group) if len(groups) > 1 else (member.group,):
            panels.setdefault((str(group), int(str(member.dimension))), []).append(str(member.problem))
    order = [ALL, *groups]
    return {_title(*key): panels[key] for key in sorted(panels, key=lambda key: (order.index(key[0]), key[1]))}


def _ranks(findings: Findings, members: pd.DataFrame) -> Table:
    ranks, panels = table_of(findings.final.standings, "rank").dropna(), _panels(members)
    rows = {title: ranks[ranks.index.isin(problems)].mean() for title, problems in panels.items()}
    shown = pd.DataFrame(rows).T.reindex(columns=findings.trials.optimizers).rename_axis("group and dimension")
    sizes = [len(problems) for problems in panels.values()]
    return Table(
        "ranks-by-group",
        "Mean rank by the chance to end lower, by group of functions and dimension, 1 for the best.",
        shown.assign(problems=sizes)[["problems", *shown]],
        bold=shown.eq(shown.min(axis=1), axis=0).mul(shown.min(axis=1) < shown.max(axis=1), axis=0),
        decimals=dict.fromkeys(map(str, shown.columns), 2),
        note="Bold: the lowest of a row, unless all are equal. Ties share their mean rank. Problems on which an "
        "optimizer has no trial do not count.",
    )


def _most_targets(reached: pd.DataFrame) -> str:
    """Return a sentence on the optimizers with the largest share of targets, by dimension, over all functions.

    ``reached`` is that of :func:`_reached`.
    """
    ends = reached[reached["per_dimension"] == reached["per_dimension"].max()]
    panels = list(dict.fromkeys(ends["problem"]))
    overall = [panel for panel in panels if panel.startswith(f"{ALL}, ")] or panels
    parts: dict[str, list[str]] = {}
    for panel in overall:
        shares = ends[ends["problem"] == panel].set_index("optimizer")["fraction"].dropna()
        if shares.max() > 0:
            most = shares.index[np.isclose(shares, shares.max(), rtol=0, atol=SAME_SHARE)]
            where = panel.removeprefix(f"{ALL}, d = ")
            parts.setdefault(listing(list(map(str, most)), 4), []).append(f"{where} ({shares.max():.0%})")
    among = "dimension " if panels != overall else ""  # there is one group, or the panels are of all functions
    shown = [f"{who} in {among}{listing(where)}" for who, where in parts.items()]
    if not shown:
        return "No trial reached a target."
    return f"Within the whole budget, the most targets were reached by {'; by '.join(shown)}."


def _reached(findings: Findings, panels: Panels) -> pd.DataFrame:
    """Return the ECDF of each optimizer in each panel, over evaluations / d."""
    trials, anytime, curves = findings.trials, findings.anytime, []
    most = max(trials.budgets[label] / d for label, d in trials.dimensions.items())
    grid = np.geomspace(1 / max(trials.dimensions.values()), most, 60)
    for title, problems in panels.items():
        shares = anytime.restarts_per_dimension if anytime.target_set.restarts else anytime.hits
        of_panel = shares[shares["problem"].isin(problems)]
        if len(of_panel):
            curve = (
                mean_shares(of_panel, anytime.curves)
                if anytime.target_set.restarts
                else analysis.ecdf(of_panel, grid, trials.dimensions)
            )
            curves.append(curve.assign(problem=title))
    columns = ["optimizer", "per_dimension", "fraction", "problem"]
    return pd.concat(curves, ignore_index=True) if curves else pd.DataFrame(columns=columns)


def _scaling(anytime: Anytime, members: pd.DataFrame) -> pd.DataFrame:
    """Return function, dimension, optimizer and ERT / d at the target of each problem."""
    table = analysis.expected_running_time(anytime.hits[np.isclose(anytime.hits["tau"], anytime.target_set.level)])
    rows = table.merge(members, on="problem")
    return rows.assign(problem=rows["function"], ert=rows["ert"] / rows["dimension"])[
        ["problem", "dimension", "optimizer", "trials", "successes", "ert"]
    ]
