"""How many optimizers a report shows, and with which pen: of many, the best stand out."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import pandas as pd

from bench.plots import style
from bench.topics.findings.final import Final
from bench.topics.findings.trials import Trials

MANY_OPTIMIZERS = 10
"""Of more optimizers than these only the best are drawn in colour, and pairs are shown as a matrix."""

WIDE = 160  # letters of the names of optimizers above which they are the rows of tables
COLOURED = 10  # optimizers, as many as there are colours
FEW = 12
"""Of more optimizers than these figures and tables of the page show the first ten and the subject; files have all."""
CROWD = 60
"""Of more optimizers than these only the best are shown problem by problem; the files of the whole study have all."""


@dataclass(frozen=True)
class Excerpt:
    """The part that is shown of many optimizers."""

    trials: Trials
    final: Final
    subject: str = ""

    @property
    def written_pairs(self) -> pd.DataFrame:
        """The tests that a report writes as a file: of a crowd, those among the best, as all would fill a disk."""
        if not self.crowd:
            return self.final.pairs
        best = self.final.ranked[:CROWD]
        return self.final.pairs[self.final.pairs["first"].isin(best) & self.final.pairs["second"].isin(best)]

    @cached_property
    def pens(self) -> style.Pens:
        """The pen of each optimizer in every figure: of many, only the best have one of their own."""
        return style.standing_out(style.pens(self.trials.optimizers, self.coloured), self.subject)

    @property
    def coloured(self) -> list[str] | None:
        """The optimizers that alone have a colour of their own, of many the best; None for all."""
        if len(self.trials.optimizers) <= MANY_OPTIMIZERS:
            return None
        first = [label for label in self.final.ranked if label != self.subject]
        return ([self.subject] if self.subject else []) + first[: COLOURED - bool(self.subject)]

    @cached_property
    def shown(self) -> list[str]:
        """The optimizers that figures and tables of the page show, in their order: of many, the first and the subject."""
        ranked = self.final.ranked
        return ranked if len(ranked) <= FEW else [*ranked[:COLOURED], *(
            [self.subject] if self.subject in ranked[COLOURED:] else []
        )]

    @property
    def upright(self) -> bool:
        """Whether optimizers are the rows of tables, because there are too many, or too long names, for columns."""
        longest = max(map(len, self.trials.optimizers), default=0)
        return len(self.trials.optimizers) > MANY_OPTIMIZERS or len(self.trials.optimizers) * longest > WIDE

    @property
    def crowd(self) -> bool:
        """Whether there are too many optimizers to show all of them problem by problem."""
        return len(self.trials.optimizers) > CROWD

    @cached_property
    def drawn(self) -> style.Pens:
        """The pens of those whose curves are drawn problem by problem: of a crowd, the best."""
        return {label: pen for label, pen in self.pens.items() if not (self.crowd and pen.background)}

    @property
    def drawn_words(self) -> tuple[str, ...]:
        """A sentence on the optimizers that are not drawn; "" if all are."""
        drawn, every = len(self.drawn), len(self.trials.optimizers)
        return (f"Drawn are the {drawn} best of {every} optimizers by mean rank.",) if drawn < every else ()
