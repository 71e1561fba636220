"""The statistics over the evaluations: targets and the time to reach them."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from bench import analysis
from bench.analysis.cells import budgets as budgets_of
from bench.analysis.cells import near_best as near_best_of
from bench.analysis.instances import SOLVED
from bench.analysis.reference import reference_times, runlength_targets
from bench.analysis.running_time import in_seconds
from bench.analysis.running_time import running_times as running_times_of
from bench.analysis.target_sets import tolerance_times
from bench.contract.families import function_of
from bench.formats.coco.best2009 import best2009
from bench.helpers.errors import BenchError
from bench.results.results import ProblemFacts
from bench.study.targets import KINDS, Targets
from bench.topics.findings.trials import Trials

NEAR = 0.01  # of the best known value
BEST = "best of 2009"  # in place of the label of an optimizer
EXPENSIVE = 1000  # evaluations / d below which targets by running length are the usual ones
LEVEL = ["problem", "tau", "precision"]

FIELD = ("bbob", "cec", "classical")
"""The beginnings of the names of the suites for which the field reports absolute precisions."""


def are_of_the_field(facts: Mapping[str, ProblemFacts], functions: Collection[str]) -> bool:
    """Return whether absolute precisions are the usual targets: in units of a design or a signal, 1e-8 means nothing.

    They are where every problem is a function with a known optimum of a suite of the field, or of another suite with
    instances (``functions``).
    """
    usual = [
        problem.optimum is not None and (label in functions or str(problem.features.get("suite", "")).startswith(FIELD))
        for label, problem in facts.items()
    ]
    return bool(usual) and all(usual)


@dataclass(frozen=True)
class Anytime:
    """The values that the trials reached on the way."""

    trials: Trials
    asked: Targets | None = None  # other than the study's own
    beside_best: bool = False  # whether the best of 2009 stands beside the optimizers

    @cached_property
    def target_set(self) -> Targets:
        """The targets: those asked for, the study's own, or the usual ones of its problems and budget."""
        if chosen := self.asked or self.trials.results.study.targets:
            return chosen
        if not are_of_the_field(self.trials.known, self.trials.precisions):
            return KINDS["relative"]
        return KINDS["runlength" if self._expensive and self._has_best else "precisions"]

    @property
    def _expensive(self) -> bool:
        """Whether every budget is below what the field calls expensive, in evaluations / d."""
        frame = self.trials.whole
        dimensions = frame["problem"].astype(object).map(self.trials.dimensions).astype(float)
        return bool((budgets_of(frame, self.trials.allowed) < EXPENSIVE * dimensions).all())

    @property
    def _has_best(self) -> bool:
        """Whether the best of 2009 is installed and has running times on every function."""
        try:
            return set(self.functions.values()) <= set(self.best["problem"])
        except BenchError:
            return False

    @cached_property
    def functions(self) -> dict[str, str]:
        """The name of the function of each problem, which has no instance."""
        names = {entry.label: entry.name for entry in self.trials.results.study.problems}
        return {label: function_of(names[self.trials.pooled.members[label][0]]) for label in self.trials.problems}

    @cached_property
    def best(self) -> pd.DataFrame:
        """The ERT of the best of 2009 on the functions; raises BenchError where there is none."""
        return best2009(self.functions.values())

    @property
    def near(self) -> float:
        """The share of the best known value within which a trial counts as near; 0 where precisions count instead.

        A share of an optimum that was shifted at will means nothing.
        """
        return 0.0 if self.target_set.absolute else NEAR

    @property
    def near_words(self) -> str:
        """The limit of what counts as near, such as ``"within 1%"``."""
        return f"within {self.near:.0%}" if self.near else f"within {SOLVED:g}"

    @cached_property
    def near_best(self) -> pd.Series:
        """The share of each optimizer's trials that came near the best known value."""
        return near_best_of(self.trials.measured_final, self.trials.optima, self.near, SOLVED)

    @property
    def shows_best(self) -> bool:
        """Whether curves and tables show the best of 2009: it was asked for, or targets are set by it."""
        return self.beside_best or self.target_set.by_best

    def check_targets(self) -> None:
        """Raise BenchError where no problem has what the targets, or the best of 2009, are measured by."""
        self.target_set.require_metric(any(facts.expected for facts in self.trials.known.values()))
        if self.beside_best and not self.target_set.absolute:
            raise BenchError(
                f"the running times of best2009 are those to precisions, and the targets are {self.target_set.short}; "
                "add --targets precisions or leave out best2009"
            )
        if self.shows_best:
            _ = self.best  # where there is none, a sentence says so

    @cached_property
    def targets(self) -> pd.DataFrame:
        """The targets of each problem."""
        chosen = self.target_set
        if chosen.by_best:
            lengths = self._run_lengths
            optimum = lengths["problem"].map(self.trials.unbeaten).astype(float)
            return pd.DataFrame(
                {"problem": lengths["problem"], "tau": lengths["tau"], "target": optimum + lengths["precision"]}
                | {"reference": optimum, "known": True}
            )
        table = analysis.target_table(chosen, self.trials.measured, self.trials.measured_traces, self.trials.optima)
        if not chosen.by_metric:
            return table
        return table[table["problem"].isin([label for label, facts in self.trials.known.items() if facts.expected])]

    def hits(self, optimizers: Collection[str]) -> pd.DataFrame:
        """Return when each trial of some optimizers reached each target; all trials at once would fill the memory."""
        return self._reached(self.targets, optimizers)

    def _reached(self, targets: pd.DataFrame, optimizers: Collection[str]) -> pd.DataFrame:
        trials, by_metric = self.trials, self.target_set.by_metric
        frame = trials.whole if by_metric else trials.measured
        frame = frame[frame["optimizer"].isin(optimizers)]
        if by_metric:
            expected = {label: facts.expected for label, facts in trials.known.items()}
            return tolerance_times(frame, trials.traces, expected, trials.allowed)
        return analysis.hitting_times(frame, trials.measured_traces, targets, trials.allowed)

    def compared(self, hits: pd.DataFrame) -> pd.DataFrame:
        """Return the hitting times of the trials that are compared, as all optimizers share their instances."""
        if not self.trials.comparable.instances:
            return hits
        keys = ["problem", "optimizer", "trial"]
        compared = pd.MultiIndex.from_frame(self.trials.frame[keys].astype(object))
        return hits[pd.MultiIndex.from_frame(hits[keys].astype(object)).isin(compared)]

    @cached_property
    def tabled_hits(self) -> pd.DataFrame:
        """When all trials reached the targets of the tables, with the ``budget`` of each trial."""
        hits = self._tabled(self._reached(self._tabled(self.targets), self.trials.optimizers))
        return hits.assign(budget=budgets_of(hits, self.trials.allowed))

    def _tabled(self, table: pd.DataFrame) -> pd.DataFrame:
        """Return the rows with a tau of the tables, without the rounding of a ladder."""
        codes, taus = pd.factorize(table["tau"].to_numpy(dtype=float))
        tabled = np.isclose(taus[:, np.newaxis], self.target_set.tabled, rtol=1e-9, atol=0)
        kept = tabled.any(axis=1)[codes]
        rounded = np.array(self.target_set.tabled)[tabled.argmax(axis=1)]
        found: pd.DataFrame = table[kept].assign(tau=rounded[codes[kept]])
        return found

    @cached_property
    def running_times(self) -> pd.DataFrame:
        """The ERT of each cell to the targets of the tables, with its spread, also by dimension and in seconds.

        The targets have the name of their unit; times in seconds end with ``_s``. Targets by running length have their
        ``precision``.
        """
        table = running_times_of(self.tabled_hits)
        times = running_times_of(in_seconds(self.tabled_hits, self.trials.whole))
        names = ["ert", "low", "high", "p10", "p90"]
        seconds = times[names].add_suffix("_s") if len(times) else pd.DataFrame(columns=[f"{name}_s" for name in names])
        dimension = table["problem"].astype(object).map(self.trials.dimensions).astype(float)
        table = table.assign(ert_per_d=table["ert"].astype(float) / dimension)
        if self.shows_best:
            best = self.best_times.set_index(["problem", "tau"])
            keys = pd.MultiIndex.from_arrays([table["problem"].astype(object), table["tau"].astype(float)])
            table = table.assign(best2009=best["ert"].reindex(keys).to_numpy())
            if self.target_set.by_best:
                table = table.assign(precision=best["precision"].reindex(keys).to_numpy())
        return pd.concat([table, seconds], axis=1).drop(columns="target").rename(columns={"tau": self.target_set.unit})

    @cached_property
    def best_times(self) -> pd.DataFrame:
        """The ERT of the best of 2009 to the targets of the tables: problem, tau, precision and ert.

        It is missing on functions without any, and where trials beat the optimum that precisions are measured from.
        """
        if not self.shows_best:
            return pd.DataFrame(columns=["problem", "tau", "precision", "ert"])
        if self.target_set.by_best:
            levels = self._run_lengths
        else:
            taus = sorted({*self.target_set.tabled, *self.target_set.levels}, reverse=True)
            kept = [label for label in self.functions if label in self.trials.unbeaten]
            levels = pd.DataFrame([(label, tau, tau) for label in kept for tau in taus], columns=LEVEL)
        return reference_times(self.best, self.functions, levels)

    @cached_property
    def _run_lengths(self) -> pd.DataFrame:
        """The targets by running length: problem, tau and precision."""
        kept = {
            label: name
            for label, name in self.functions.items()
            if label in self.trials.unbeaten and label in self.trials.dimensions
        }
        table = runlength_targets(self.best, kept, self.trials.dimensions)
        return table.assign(tau=1 / table["length"])[LEVEL]

    @cached_property
    def aocc(self) -> pd.DataFrame:
        """The area over the convergence curve of each cell on problems whose optimum is known and not beaten."""
        return analysis.aocc(
            self.trials.measured, self.trials.measured_traces, self.trials.unbeaten, self.trials.budgets
        )

    @cached_property
    def u_scores(self) -> pd.DataFrame:
        """The U-scores of each cell on functions of suites, by trial-based dominance."""
        trials = self.trials.measured[self.trials.measured["problem"].isin(self.trials.suite_functions)]
        return analysis.u_scores(trials, self.trials.measured_traces, self.trials.unbeaten)
