"""How many optimizers a report shows, and with which pen."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from bench.plots import style
from bench.topics.findings.final import FIRST, Final
from bench.topics.findings.trials import Trials

FEW = 12
"""Of more optimizers, figures and tables show the first ten and the subject."""


@dataclass(frozen=True)
class Excerpt:
    """The part that is shown of many optimizers."""

    trials: Trials
    final: Final
    subject: str = ""

    @cached_property
    def shown(self) -> list[str]:
        """The optimizers that figures and tables of the page show, in their order."""
        ranked = self.final.ranked
        return ranked if len(ranked) <= FEW else [*ranked[:FIRST], *({self.subject} & set(ranked[FIRST:]))]

    @cached_property
    def pens(self) -> style.Pens:
        """The pen of each optimizer in every figure: only those that are shown have one of their own."""
        return style.standing_out(style.pens(self.trials.optimizers, self.shown), self.subject)
