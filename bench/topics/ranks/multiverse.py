"""The first optimizer under other analyses that could have been chosen."""

from __future__ import annotations

import pandas as pd

from bench.report.parts import Section, Table
from bench.report.prose import speaker
from bench.report.wording import listing
from bench.topics.findings import Findings

TITLE = "Would another analysis say the same?"
NAMED = 2  # optimizers that share the first place, in a cell
ANALYSIS = ["measure", "sample", "share"]
SAY = speaker(__package__)


def sections(findings: Findings) -> list[Section]:
    """Return who is first under each analysis; nothing where no trial left a trace."""
    leader, *rivals = findings.from_leader
    found = findings.anytime.multiverse(leader) if findings.trials.traces else pd.DataFrame()
    if found.empty:
        return []
    least = found.groupby(ANALYSIS)["rank"].transform("min")
    firsts = found[found["rank"] == least].groupby(ANALYSIS, sort=False)["optimizer"].agg(list)
    behind = (found["behind"] == 1).groupby(found["optimizer"]).sum()
    alone = sum(names == [leader] for names in firsts)
    text = SAY("multiverse", leader, alone, len(firsts), [f"{rival} in {behind[rival]}" for rival in rivals])
    order = list(dict.fromkeys(zip(found["measure"], found["sample"], strict=True)))
    wide = (
        firsts.unstack("share").reindex(order).rename(columns=lambda share: f"at {share:.0%}").rename_axis(columns=None)
    )
    several = findings.trials.precisions != []
    wide.index = pd.Index(
        [_words(measure, sample, several) for measure, sample in order],
        name="measure",
    )
    table = Table(
        "multiverse",
        "The first optimizer over all problems by other measures, and at smaller shares of the budget.",
        wide.map(_named),
        bold=wide.map(lambda names: names == [leader]),
        note=SAY("measures", several) + f" Bold: {leader} alone.",
        data=found,
    )
    return [Section(TITLE, (text,), (table,), folded=True)]


def _words(measure: str, sample: str, several: bool) -> str:
    """Return an analysis in words; a set of targets has no sample."""
    if not sample:
        return f"targets: {measure}"
    return f"{measure}, {sample}" if several else measure


def _named(names: object) -> str:
    """Return the first ones, or how many share the place; "–" where nothing was reached."""
    if not isinstance(names, list):
        return "–"
    return listing(names) if len(names) <= NAMED else f"{len(names)} share it"
