"""Results that show themselves in a notebook or a script: the verdict with its table, and the usual pictures."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from bench import analysis, plots
from bench.helpers.errors import BenchError, nearest
from bench.helpers.parsing import JsonObject
from bench.helpers.text import html_table
from bench.results.results import AnyPath, StoredResults
from bench.topics.answer.facts import facts
from bench.topics.answer.file import answer
from bench.topics.answer.section import lines
from bench.topics.findings import Findings
from bench.topics.write import write_report

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Results(StoredResults):
    """The contents of a study's folder, or of several that can be compared, which show themselves.

    Printed, they are the verdict with its table; a notebook adds the numbers of trials. What they hold, and what may be
    wrong with a folder, is described at :class:`bench.results.results.StoredResults`.
    """

    def __str__(self) -> str:
        """Return the verdict, as a report begins with it, and its table."""
        found = self.answer
        rows = pd.DataFrame(found["rows"], columns=found["columns"]).to_string(index=False) if found["rows"] else ""
        lines = [f"{label}: {text}" for label, text in found["lines"]]
        return "\n".join(filter(None, (found["sentence"], *lines, found["selection"], rows, found["more"])))

    def _repr_html_(self) -> str:
        """Return the verdict with its table, where anything is compared, and the numbers of trials."""
        found = self.answer
        caption = " ".join(filter(None, (found["sentence"], found["selection"], found["more"])))
        table = html_table(caption, found["rows"], found["columns"]) if found["rows"] else ""
        return table + self._counts()

    @cached_property
    def answer(self) -> JsonObject:
        """The verdict, its lines and its table, as a terminal shows them."""
        findings = Findings(self)
        return answer(findings, lines(findings))

    def _counts(self) -> str:
        """Return the numbers of trials as a table."""
        found: dict[str, Counter[str]] = {entry.label: Counter() for entry in self.study.optimizers}
        for source, cells in self._shown:
            for cell in source.folder.store.cells(cells):
                found[cell.optimizer].update(cell.status)
        rows = [(label, f"{count['ok']:,}", f"{count.total() - count['ok']:,}") for label, count in found.items()]
        about = f"{len(self.study.problems):,} problems, {self.study.budget_words}"
        return html_table(f"Results of study {self.study.name}: {about}", rows, ("optimizer", "trials", "failed"))

    @property
    def plot(self) -> Plots:
        """Plots of the results, such as ``results.plot.chances()`` (:class:`bench.comparison.notebook.Plots`)."""
        return Plots(self)

    def report(self, output: AnyPath | None = None, **settings: Any) -> Path:
        """Write the report and return the path of its page.

        Args:
            output: the folder to write into; by default the study's own. A selection needs one.
            settings: further arguments of :func:`bench.write_report`.

        Raises:
            BenchError: as :func:`bench.write_report`.
        """
        if self.study is not self.whole:
            chosen = {"optimizers": self.study.optimizers, "problems": self.study.problems}
            settings = {key: [entry.label for entry in entries] for key, entries in chosen.items()} | settings
        return write_report(*self.paths, output=output, **settings)


@dataclass(frozen=True)
class Plots:
    """The usual pictures, as ``results.plot.chances()``: each draws on ``ax``, or on new axes, and returns it.

    :mod:`bench.plots` has more, for the frames of :mod:`bench.analysis`.
    """

    _results: StoredResults

    def chances(self, *, ax: Axes | None = None) -> Axes:
        """Draw the chance that a run of the first optimizer, or of the subject, ends lower, against each rival."""
        return plots.a12_forest(Findings(self._results).of(facts).rivals, ax=ax)

    def values(self, problem: str | None = None, *, ax: Axes | None = None) -> Axes:
        """Draw the values that the trials of each optimizer reached on a problem; by default on the first one."""
        return plots.box_plot(self._ordered, self._label(problem), ax=ax)

    def convergence(self, problem: str | None = None, *, ax: Axes | None = None) -> Axes:
        """Draw the median best value of each optimizer over the evaluations on a problem, with its quartiles."""
        frame, label = self._ordered, self._label(problem)
        frame = frame[frame["problem"] == label]
        grid = analysis.evaluation_grid(int(frame["nfev"].max()))
        return plots.convergence(analysis.convergence(frame, self._results.traces, grid), label, ax=ax)

    @property
    def _ordered(self) -> pd.DataFrame:
        return analysis.in_study_order(self._results.frame, self._results.study)

    def _label(self, problem: str | None) -> str:
        labels = [entry.label for entry in self._results.study.problems]
        if problem is not None and problem not in labels:
            raise BenchError(f"the study has no problem {problem!r}{nearest(problem, labels)}")
        return labels[0] if problem is None else problem
