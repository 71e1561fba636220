"""Compute the statistics of a study once for all sections of its report.

:class:`Findings` holds four parts, each computed from those before it: :class:`Trials` (what was run), :class:`Final`
(what the trials reached at the end), :class:`Anytime` (on the way) and :class:`Excerpt` (how much of it is shown).
:meth:`Findings.of` keeps what a topic computes besides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeVar, cast

from bench.contract.families import function_of
from bench.results.results import StoredResults
from bench.study import Study
from bench.study.descriptions import Descriptions, noted
from bench.study.targets import Targets
from bench.study.values import Checked
from bench.topics.findings.anytime import BEST, Anytime
from bench.topics.findings.display import FEW, Excerpt
from bench.topics.findings.final import CROWD, FIRST, Final
from bench.topics.findings.selection import selection, versions
from bench.topics.findings.trials import Trials

__all__ = [
    "BEST",
    "CROWD",
    "FEW",
    "FIRST",
    "Anytime",
    "Excerpt",
    "Final",
    "Findings",
    "Trials",
]

Found = TypeVar("Found")


@dataclass(frozen=True)
class Findings:
    """The analysis of a study; every frame has the cells of the study in the study's order.

    Attributes:
        results: the content of the study's folder.
        asked: targets other than the study's own.
        beside_best: whether the best of 2009 stands beside the optimizers.
        asked_subject: the optimizer that the page is about, other than the study's own.
    """

    results: StoredResults
    asked: Checked[Targets | None] = Checked(Targets.read)
    beside_best: bool = False
    asked_subject: str | None = None
    _computed: dict[object, object] = field(default_factory=dict, init=False, repr=False, compare=False)

    def of(self, compute: Callable[[Findings], Found]) -> Found:
        """Return the result of a function of these findings, which is called once, however many topics ask for it."""
        if compute not in self._computed:
            self._computed[compute] = compute(self)
        return cast("Found", self._computed[compute])

    @cached_property
    def trials(self) -> Trials:
        """The trials that were run."""
        return Trials(self.results)

    @cached_property
    def final(self) -> Final:
        """The values that the trials reached at the end."""
        return Final(self.trials, self.subject if self.declared else "", self.subject)

    @cached_property
    def anytime(self) -> Anytime:
        """The values that the trials reached on the way."""
        return Anytime(self.trials, self.asked, self.beside_best)

    @cached_property
    def display(self) -> Excerpt:
        """How much of it is shown."""
        return Excerpt(self.trials, self.final, self.subject)

    @property
    def subject(self) -> str:
        """The optimizer that the page is about; "" where it is about all, or has no trials of it."""
        subject = self.results.study.subject if self.asked_subject is None else self.asked_subject
        return subject if subject in self.trials.optimizers else ""

    @property
    def first_subject(self) -> str:
        """The subject that the first run named; "" without one, or where no run is on record."""
        runs = [record for record in self.results.environments if not record.get("imported")]
        first = min(runs, key=lambda record: str(record.get("started", "")), default={})
        return str(first.get("subject") or "")

    @property
    def declared(self) -> bool:
        """Whether the first run already named the subject; only then are other pairs no hypotheses of the page."""
        return bool(self.subject) and self.first_subject == self.subject

    @property
    def leader(self) -> str:
        """The subject, or without one the optimizer that is first in rank; the page compares it with each other one."""
        return self.subject or self.final.ranked[0]

    @property
    def from_leader(self) -> list[str]:
        """The optimizer that the page speaks for, and its rivals in rank."""
        return [self.leader, *(label for label in self.final.ranked if label != self.leader)]

    @property
    def study(self) -> Study:
        """The study as it is compared."""
        return self.trials.study

    @property
    def state(self) -> str:
        """What the folder held when these were found; "" for several, and where this is not all that it asks for."""
        usual = (self.asked, self.beside_best, self.asked_subject, self.results.partial) == (None, False, None, False)
        return self.results.state if usual else ""

    @cached_property
    def selection(self) -> str:
        """Sentences on the optimizers, problems and versions that a selection leaves out; "" for a whole study."""
        shown = self.results.study
        functions = {function_of(entry.label) for entry in shown.problems}
        sentences = (
            selection(self.results.whole, shown, by_instance=len(functions) < len(self.study.problems)),
            self.versions,
        )
        return " ".join(filter(None, sentences))

    @property
    def versions(self) -> str:
        """Sentences on optimizers that were changed after results of theirs were seen; "" where none was."""
        return versions(self.results.versions, self.results.beside)

    @cached_property
    def descriptions(self) -> Descriptions:
        """The optimizers as their plug-ins described them when the study ran, by label."""
        return noted(self.study, self.results.descriptions)
