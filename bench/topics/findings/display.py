"""How many optimizers a report shows, and with which pen."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import pandas as pd

from bench.plots import style
from bench.topics.findings.final import Final
from bench.topics.findings.trials import Trials

FEW, FIRST = 12, 10
"""Of more optimizers than the one, figures and tables show the first ones, as many as the other, and the subject."""
CROWD = 60
"""Of more optimizers than these the file of tests has those between the first ones, as all would fill a disk."""


@dataclass(frozen=True)
class Excerpt:
    """The part that is shown of many optimizers."""

    trials: Trials
    final: Final
    subject: str = ""

    @property
    def written_pairs(self) -> pd.DataFrame:
        """The tests that a report writes as a file."""
        first = self.final.ranked[:CROWD]
        pairs = self.final.on_problems
        return pairs[pairs["first"].isin(first) & pairs["second"].isin(first)]

    @cached_property
    def shown(self) -> list[str]:
        """The optimizers that figures and tables of the page show, in their order."""
        ranked = self.final.ranked
        return ranked if len(ranked) <= FEW else [*ranked[:FIRST], *({self.subject} & set(ranked[FIRST:]))]

    @cached_property
    def pens(self) -> style.Pens:
        """The pen of each optimizer in every figure: only those that are shown have one of their own."""
        return style.standing_out(style.pens(self.trials.optimizers, self.shown), self.subject)
