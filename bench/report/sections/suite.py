"""A suite at a glance: ranks and targets reached by group of functions and dimension, and how running times scale."""

from __future__ import annotations

import numpy as np
import pandas as pd

from bench import analysis
from bench.report.findings import Anytime, Findings, Trials
from bench.report.parts import Part, Section, Table
from bench.report.plots import group_figure, scaling_figure
from bench.report.wording import count, listing

TITLE = "The suite at a glance"
ALL = "all functions"
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
    items: list[Part] = [_ranks(findings, members)]
    if findings.trials.traces:
        reached = _reached(findings, members)
        items.insert(0, group_figure(reached, findings.display.drawn, restarts=findings.anytime.words.restarts))
        if members.groupby("function")["dimension"].nunique().max() > 1:
            words = findings.anytime.words
            items.append(
                scaling_figure(
                    _scaling(findings.anytime, members), findings.display.drawn, target=words.at(words.level)
                )
            )
    text = [_meaning(findings.trials, members)]
    if findings.trials.traces:
        most = max(findings.trials.budgets[label] / d for label, d in findings.trials.dimensions.items())
        text.insert(0, _most_targets(reached[reached["per_dimension"] <= most * (1 + 1e-9)]))
    return Section(TITLE, (*text, *findings.display.drawn_words), tuple(items))


def _members(trials: Trials) -> pd.DataFrame:
    """Return problem, function, group and dimension of the problems that have all of these features."""
    rows = [
        (label, f"{known.features.get('suite', '')} {known.features.get('function', label)}".strip(),
         str(known.features["group"]), trials.dimensions[label])
        for label, known in trials.known.items()
        if "group" in known.features and label in trials.dimensions
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=["problem", "function", "group", "dimension"])


def _meaning(trials: Trials, members: pd.DataFrame) -> str:
    functions, dimensions = members["function"].nunique(), sorted(members["dimension"].unique())
    shown = listing([f"{each:g}" for each in dimensions])
    text = (
        f"{count(functions, 'function')} in {count(members['group'].nunique(), 'group')}, in "
        f"{'dimensions' if len(dimensions) > 1 else 'dimension'} {shown}. A problem is a function in one dimension."
    )
    pools = [own for own in trials.pooled.members.values() if len(own) > 1]
    if pools:
        each = f"instances ({listing(sorted({f'{len(own)}' for own in pools}, key=int))} each)"
        some = len(pools) < len(members)
        text += (
            f" {f'On {len(pools)} of {len(members)} problems, the' if some else 'Its'} {each} are pooled, as COCO "
            f"does: all their trials are trials of the problem, and {'the' if some else 'its'} values are precisions, "
            f"the best objective value less the optimum of the instance, taken as 0 from {analysis.SOLVED:g} on."
            + (" The values of the others are objective values." if some else "")
        )
    return text


def _panels(members: pd.DataFrame) -> list[tuple[str, int, list[str]]]:
    """Return group, dimension and problems of each panel: first all functions, then each group, by dimension."""
    panels: dict[tuple[str, int], list[str]] = {}
    groups = list(dict.fromkeys(members["group"]))
    for each in members.itertuples(index=False):
        for group in (ALL, each.group) if len(groups) > 1 else (each.group,):
            panels.setdefault((str(group), int(str(each.dimension))), []).append(str(each.problem))
    order = [ALL, *groups]
    return [(*key, panels[key]) for key in sorted(panels, key=lambda key: (order.index(key[0]), key[1]))]


def _ranks(findings: Findings, members: pd.DataFrame) -> Table:
    ranks, panels = analysis.table(findings.final.standings, "rank").dropna(), _panels(members)
    rows = {
        f"{group}, d = {dimension}": ranks[ranks.index.isin(problems)].mean() for group, dimension, problems in panels
    }
    shown = pd.DataFrame(rows).T.reindex(columns=findings.trials.optimizers).rename_axis("group and dimension")
    problems = [len(problems) for _, _, problems in panels]
    return Table(
        "ranks-by-group",
        "Mean rank by the rivals beaten, by group of functions and dimension, 1 for the best.",
        shown.assign(problems=problems)[["problems", *shown]],
        bold=shown.eq(shown.min(axis=1), axis=0).mul(shown.min(axis=1) < shown.max(axis=1), axis=0),
        decimals=dict.fromkeys(map(str, shown.columns), 2),
        note="Bold: the lowest of a row, unless all are equal. Ties share their mean rank. Problems on which an "
        "optimizer has no trial do not count.",
    )


def _most_targets(reached: pd.DataFrame) -> str:
    """Return which optimizer reached the largest share of targets in each of the first panels, those of all functions.

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


def _reached(findings: Findings, members: pd.DataFrame) -> pd.DataFrame:
    """Return the ECDF of each optimizer in each panel, over evaluations / d."""
    if findings.anytime.words.restarts:
        return _restarted(findings, members)
    hits = findings.anytime.hits
    most = max(findings.trials.budgets[label] / d for label, d in findings.trials.dimensions.items())
    grid = np.geomspace(1 / max(findings.trials.dimensions.values()), most, 60)
    curves = []
    for group, dimension, problems in _panels(members):
        own = hits[hits["problem"].isin(problems)]
        curve = analysis.ecdf(own, grid, findings.trials.dimensions)
        curves.append(curve.assign(problem=f"{group}, d = {dimension}"))
    return pd.concat(curves, ignore_index=True)


def _restarted(findings: Findings, members: pd.DataFrame) -> pd.DataFrame:
    """Return the share of simulated restarts of each optimizer in each panel, over evaluations / d."""
    shares = findings.anytime.restarts_per_dimension
    curves = [
        analysis.mean_shares(own, findings.trials.optimizers).assign(problem=f"{group}, d = {dimension}")
        for group, dimension, problems in _panels(members)
        if len(own := shares[shares["problem"].isin(problems)])
    ]
    return pd.concat(curves, ignore_index=True) if curves else pd.DataFrame(columns=[*shares, "problem"])


def _scaling(anytime: Anytime, members: pd.DataFrame) -> pd.DataFrame:
    """Return function, dimension, optimizer and ERT / d at the target of each problem."""
    table = analysis.expected_running_time(anytime.hits[np.isclose(anytime.hits["tau"], anytime.words.level)])
    own = table.merge(members, on="problem")
    return own.assign(problem=own["function"], ert=own["ert"] / own["dimension"])[
        ["problem", "dimension", "optimizer", "trials", "successes", "ert"]
    ]
