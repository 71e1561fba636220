"""Whether the trials were enough: how many would separate more pairs."""

from __future__ import annotations

import numpy as np
import pandas as pd

from bench.analysis.integrity import undeclared
from bench.analysis.trials_needed import LARGEST
from bench.report.parts import Part, Section, Table
from bench.report.wording import count, interval
from bench.topics.findings import Final, Findings
from bench.topics.topic import Topic

TITLE = "Enough trials"
SHOWN = 40  # rows of the table on the page
CAUTION = (
    "The estimates take the trials made for the truth, so they are as uncertain as A12 is, and a pair that is equal "
    "looks as if more trials could separate it. To add trials because of them, or of p-values, is optional stopping: a "
    "new study with another seed keeps its level."
)


def section(findings: Findings) -> Section:
    """Return the section, or one that states that there is nothing to compare."""
    if findings.trials.frame.empty or len(findings.trials.optimizers) < 2 or not len(findings.final.medians):
        return Section(TITLE, ("There is nothing to compare, so no number of trials can be judged.",), on_demand=True)
    text = [
        *extension_text(findings),
        *summary(findings.final.needed, len(findings.final.tested_pairs)),
    ]
    if findings.trials.precisions:
        text.append("Where instances are pooled, the trials of all of them count, one of each instance in turn.")
    items: list[Part] = []
    if len(findings.final.needed):
        items.append(_needed(findings.final))
    return Section(TITLE, tuple(text), tuple(items), on_demand=True)


def summary(needed: pd.DataFrame, pairs: int, power: float = 0.8) -> list[str]:
    """Return sentences on how many pairs would be separated by how many trials."""
    if needed.empty:
        return [f"{'The pair of optimizers is' if pairs == 1 else f'All {pairs:,} pairs are'} separated."]
    wanted = needed["needed"].to_numpy(dtype=float)
    finite = np.sort(wanted[np.isfinite(wanted)])
    whose = "of the pairs with the leader of a problem, " if (needed["method"] == "formula").any() else ""
    text = f"{count(len(needed), 'pair')} {'is' if len(needed) == 1 else 'are'} not separated. "
    if whose:
        text = f"{whose[0].upper()}{whose[1:]}{text[0].lower()}{text[1:]}"
    parts = []
    if len(finite):
        span = f"{finite[0]:,.0f}" if finite[0] == finite[-1] else f"{finite[0]:,.0f} to {finite[-1]:,.0f}"
        parts.append(f"{span} trials of each optimizer would separate {_of(len(finite), len(needed), 'it')}")
    if far := int(np.isinf(wanted).sum()):
        parts.append(f"{_of(far, len(needed), 'it')} would need more than {LARGEST:,}: practically not separable")
    if unknown := int(np.isnan(wanted).sum()):
        parts.append(f"nothing can be said of {_of(unknown, len(needed), 'it')}, with fewer than two trials in a cell")
    return [f"{text}With a power of {power:.0%}, {'; '.join(parts)}.", CAUTION]


def _of(number: int, pairs: int, it: str) -> str:
    return it if pairs == 1 else f"all {pairs:,}" if number == pairs else f"{number:,} of them"


def extension_text(findings: Findings) -> list[str]:
    """Return the sentences on trials added to complete ones; none where there were none."""
    return [
        f"Optional stopping: {held:,} trials of each cell were complete, and could be looked at, when {asked:,} were "
        "asked for. If the results were a reason for that, the p-values are too small and the tests err more often "
        "than alpha says."
        for held, asked in undeclared(findings.trials.extensions)
    ]


def rows(needed: pd.DataFrame) -> pd.DataFrame:
    """Return the estimates in words, the smallest numbers first."""
    ordered = needed.sort_values(["needed", "low"], kind="stable")
    smaller = ordered[["n_first", "n_second"]].min(axis=1)
    return pd.DataFrame(
        {
            "problem": ordered["problem"].astype(object),
            "first": ordered["first"].astype(object),
            "second": ordered["second"].astype(object),
            "trials": smaller.astype(int),
            "A12": ordered["a12"],
            "interval": [interval(*ends, 2) for ends in zip(ordered["a12_low"], ordered["a12_high"], strict=True)],
            "needed": list(map(_number, ordered["needed"])),
            "range": [
                "" if np.isnan(low) else f"{_number(low)} to {_number(high)}"
                for low, high in zip(ordered["low"], ordered["high"], strict=True)
            ],
            "more": [
                f"{wanted - made:,.0f}" if np.isfinite(wanted) else ""
                for wanted, made in zip(ordered["needed"], smaller, strict=True)
            ],
        }
    ).reset_index(drop=True)


def _number(trials: float) -> str:
    return "–" if np.isnan(trials) else f">{LARGEST:,}" if np.isinf(trials) else f"{trials:,.0f}"


def _needed(final: Final) -> Table:
    shown, method = rows(final.needed), final.needed["method"].iloc[0]
    how = (
        "simulated by drawing from the samples, with the test and level of this report"
        if method == "simulation"
        else "by Noether’s formula, of the pairs with the leader of a problem"
    )
    rest = f" The page shows {SHOWN} of {len(shown):,} pairs." if len(shown) > SHOWN else ""
    return Table(
        "trials-needed",
        f"The trials of each optimizer that would separate pairs that are not separated, with a power of 80%, {how}.",
        shown.head(SHOWN),
        decimals={"A12": 2},
        note="A12 with its 95% interval; the range of the number is that of the interval. The level of a pair is "
        f"{final.level_on_problems:g} over the pairs of all problems that are not separated.{rest}",
        data=final.needed,
    )


TOPIC = Topic(TITLE, section, place=700)
