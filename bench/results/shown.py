"""Show results in a notebook or a script: the verdict with its table, the numbers of trials, and the usual pictures.

The verdict and the drawing functions stand above this package: they are imported by name at their first use, as
``bench`` itself imports them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

import pandas as pd

from bench import analysis
from bench.errors import BenchError, nearest
from bench.helpers.text import html_table
from bench.results.sources import Source
from bench.study import Study

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def answer(results: object) -> dict[str, Any]:
    """Return the answer of a report on results in a few lines, as ``bench run`` prints it."""
    findings = import_module("bench.topics.findings").Findings(results)
    section = import_module("bench.topics.verdict.section").section(findings)
    found: dict[str, Any] = import_module("bench.topics.verdict.answer").answer(findings, section)
    return found


def as_text(answer: dict[str, Any]) -> str:
    """Return an answer as lines of text: the verdict, and the table below it."""
    rows = pd.DataFrame(answer["rows"], columns=answer["columns"]).to_string(index=False) if answer["rows"] else ""
    return "\n".join(filter(None, (answer["sentence"], answer["selection"], rows, answer["more"])))


def as_html(answer: dict[str, Any]) -> str:
    """Return an answer as a table for a notebook, with the verdict as its caption; "" where nothing is compared."""
    caption = " ".join(filter(None, (answer["sentence"], answer["selection"], answer["more"])))
    return html_table(caption, answer["rows"], answer["columns"]) if answer["rows"] else ""


def counts(study: Study, sources: Iterable[Source]) -> str:
    """Return the numbers of trials as a table for a notebook; damaged trials are counted as they are stored."""
    problems = {entry.label for entry in study.problems}
    found: dict[str, Counter[str]] = {entry.label: Counter() for entry in study.with_controls}
    for source in sources:
        for cell in source.folder.store.cells():
            label = source.shown.get(cell.optimizer, cell.optimizer)
            if cell.problem in problems and label in found:
                found[label].update(cell.status)
    rows = [(label, f"{count['ok']:,}", f"{count.total() - count['ok']:,}") for label, count in found.items()]
    about = f"{len(problems):,} problems, {study.budget_words}"
    return html_table(f"Results of study {study.name}: {about}", rows, ("optimizer", "trials", "failed"))


@dataclass(frozen=True)
class Plots:
    """The usual pictures of results, as ``results.plot.ranks()``: each draws on ``ax``, or on new axes, and returns it.

    :mod:`bench.plots` has more, for the frames of :mod:`bench.analysis`.
    """

    _study: Study
    _frame: Callable[[], pd.DataFrame]
    _traces: Callable[[], analysis.Traces]
    _pooled: Callable[[], pd.DataFrame]

    def ranks(self, *, ax: Axes | None = None) -> Axes:
        """Draw the mean rank of each optimizer over the problems; a bar joins those that no test tells apart."""
        frame = self._pooled()
        pairs = analysis.pairwise_tests(frame)
        means = analysis.mean_ranks(analysis.standings(analysis.summarise(frame), pairs))
        return _draw("cd_diagram", means, analysis.cliques(means, analysis.across_problems(pairs)), ax=ax)

    def values(self, problem: str | None = None, *, ax: Axes | None = None) -> Axes:
        """Draw the values that the trials of each optimizer reached on a problem; by default on the first one."""
        return _draw("box_plot", self._ordered, self._label(problem), ax=ax)

    def convergence(self, problem: str | None = None, *, ax: Axes | None = None) -> Axes:
        """Draw the median best value of each optimizer over the evaluations on a problem, with its quartiles."""
        frame, label = self._ordered, self._label(problem)
        frame = frame[frame["problem"] == label]
        grid = analysis.evaluation_grid(int(frame["nfev"].max()))
        return _draw("convergence", analysis.convergence(frame, self._traces(), grid), label, ax=ax)

    @property
    def _ordered(self) -> pd.DataFrame:
        return analysis.in_study_order(self._frame(), self._study)

    def _label(self, problem: str | None) -> str:
        labels = [entry.label for entry in self._study.problems]
        if problem is not None and problem not in labels:
            raise BenchError(f"the study has no problem {problem!r}{nearest(problem, labels)}")
        return labels[0] if problem is None else problem


def _draw(function: str, *arguments: object, ax: Axes | None) -> Axes:
    drawn: Axes = getattr(import_module("bench.plots"), function)(*arguments, ax=ax)
    return drawn
