"""The share of targets that each optimizer has reached over the budget, with bands, and who is ahead when."""

from __future__ import annotations

from itertools import chain
from typing import NamedTuple

import numpy as np
import pandas as pd

from bench import analysis
from bench.analysis.bands import curve_bands, leads, spells
from bench.topics.findings import Findings

POINTS = 60  # of the grid
RIVALS = 8  # of the leader, the nearest ones
MOST_BANDS = 6  # curves up to which bands can be distinguished


class Compared(NamedTuple):
    """What curves are made of.

    Attributes:
        hits: when runs of the optimizers that are shown reached their targets, on the problems that count.
        problems: the problems that count.
        grid: increasing numbers of evaluations, or of evaluations a dimension where budgets differ.
        dimensions: of the problems, where the unit is an evaluation a dimension.
        banded: whether every optimizer has two runs or more on each of these problems.
    """

    hits: pd.DataFrame
    problems: list[str]
    grid: np.ndarray
    dimensions: dict[str, int] | None
    banded: bool

    @property
    def unit(self) -> str:
        """The column of the budget."""
        return "evaluations" if self.dimensions is None else "per_dimension"


def compared(findings: Findings) -> Compared:
    """Return the problems on which every optimizer has two runs or more; where there is none, all of them."""
    trials, anytime = findings.trials, findings.anytime
    hits = anytime.compared(anytime.hits(findings.display.shown))
    dimensions = trials.dimensions if trials.scaled else None
    counts = trials.frame.groupby(["problem", "optimizer"], observed=True).size().unstack()
    several = (counts.reindex(columns=trials.optimizers) > 1).all(axis=1)
    kept = [str(label) for label in several.index[several] if dimensions is None or label in dimensions]
    banded = bool(kept) and bool(hits["problem"].isin(kept).any())
    kept = kept if banded else [label for label in trials.problems if dimensions is None or label in dimensions]
    hits = hits[hits["problem"].isin(kept)]
    budgets = trials.common or trials.budgets
    ends = [budgets[label] / (dimensions[label] if dimensions else 1) for label in kept]
    first = 1 / max(dimensions[label] for label in kept) if dimensions and kept else 1
    last = (min if banded else max)(ends, default=first)
    return Compared(hits, kept, np.unique(np.geomspace(first, last, POINTS)), dimensions, banded)


def curves(findings: Findings) -> pd.DataFrame:
    """Return the curve of each optimizer that is shown: optimizer, the unit, fraction, and of some low and high."""
    hits, _, grid, dimensions, banded = findings.of(compared)
    shown = findings.display.shown
    parts = []
    if banded:
        parts.append(curve_bands(hits[hits["optimizer"].isin(shown[:MOST_BANDS])], grid, dimensions))
    others = shown[MOST_BANDS:] if banded else shown
    if others:
        parts.append(analysis.ecdf(hits[hits["optimizer"].isin(others)], grid, dimensions))
    table: pd.DataFrame = pd.concat([part for part in parts if len(part)], ignore_index=True)
    table = table[table["optimizer"].isin(shown)].dropna(subset="fraction")
    return table.reset_index(drop=True)


def span(table: pd.DataFrame, unit: str) -> tuple[float, float]:
    """Return the budgets that are drawn: from where a curve has a tenth of the highest share, to the last one."""
    budgets, fraction = table[unit].astype(float), table["fraction"]
    begin = budgets[fraction >= fraction.max() / 10].min()
    return float(budgets[budgets < begin].max() if (budgets < begin).any() else begin), float(budgets.max())


def rivals(findings: Findings) -> list[str]:
    """Return the rivals of the leader of which is said when one of both is ahead."""
    return findings.from_leader[1 : RIVALS + 1]


def ahead(findings: Findings) -> pd.DataFrame:
    """Return when the leader, or a rival of it, is shown to be ahead (:func:`bench.analysis.bands.spells`)."""
    found, anytime, shown = findings.of(compared), findings.anytime, findings.display.shown
    if not found.banded or len(findings.trials.optimizers) < 2:
        return pd.DataFrame(columns=["first", "second", "ahead", "begin", "end"])
    pairs = [(findings.leader, rival) for rival in rivals(findings)]
    others = (anytime.compared(anytime.hits([label])) for label in findings.final.ranked if label not in shown)
    parts = chain([found.hits], (hits[hits["problem"].isin(found.problems)] for hits in others))
    return spells(leads(parts, found.grid, found.dimensions, pairs))
