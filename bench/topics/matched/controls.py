"""Compare the leader with its rivals under the same conditions, and estimate what the missing controls would cost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import pandas as pd

from bench.analysis.across import improvement_of
from bench.analysis.strata import strata
from bench.helpers.console import duration
from bench.plugins import registry
from bench.report.wording import count, options
from bench.study.matched import Matched, algorithms, matched
from bench.topics.findings import Findings
from bench.topics.findings.final import Final
from bench.topics.findings.trials import Trials

REPORTED = "as reported"
RIVALS = 5
"""The rivals of the leader that are compared, the best by mean rank."""

COLUMNS = ("conditions", "rival", "first", "second", "problems", "probability", "low", "high")


@dataclass(frozen=True)
class Controls:
    """The optimizers under each other's conditions.

    Attributes:
        matched: the conditions that optimizers of the study have, each with all algorithms; none of several folders.
        leader: the optimizer whose rivals are compared with it.
    """

    trials: Trials
    final: Final
    matched: Sequence[Matched]
    leader: str

    @cached_property
    def chances(self) -> pd.DataFrame:
        """The probability that a run of the leader beats one of each rival, as reported and under each condition.

        One row a condition and rival, with the columns ``COLUMNS``: ``first`` and ``second`` are the labels of the
        optimizers or controls whose runs are compared, ``probability`` is the mean over problems of A12 with its 95%
        interval. Conditions are left out under which the leader has no trials.
        """
        kinds, ranked = algorithms(self.trials.results.study), self.final.ranked
        if not len(self.final.medians):
            return pd.DataFrame(columns=list(COLUMNS))
        leader = self.leader
        best = {kind: label for label in reversed(ranked) if (kind := kinds[label]) != kinds[leader]}  # of an algorithm
        rivals = sorted(best.values(), key=ranked.index)[:RIVALS]
        rows = [(REPORTED, rival, leader, rival, *self._chance(leader, rival)) for rival in rivals]
        for same in self.matched:
            name = options(same.values)
            for rival in rivals:
                pair = [same.entries[kinds[label]].label for label in (leader, rival) if kinds[label] in same.entries]
                if len(pair) == 2 and (chance := self._chance(*pair))[0]:
                    rows.append((name, rival, pair[0], pair[1], *chance))
        return pd.DataFrame(rows, columns=list(COLUMNS))

    def _chance(self, first: str, second: str) -> tuple[int, float, float, float]:
        """Return problems, probability, low and high of two optimizers or controls."""
        pair = self._every[self._every["optimizer"].isin((first, second))]
        pair = pair.assign(optimizer=pd.Categorical(pair["optimizer"], [first, second]))
        samples = [
            by_stratum
            for problem, by_stratum in strata(pair).items()
            if problem in self.final.medians.index and all(map(len, by_stratum[0]))
        ]
        return len(samples), *improvement_of(samples)

    @cached_property
    def _every(self) -> pd.DataFrame:
        """The trials of optimizers and controls."""
        frames = [frame for frame in (self.trials.frame, self.trials.controls) if len(frame)]
        names = ["problem", "optimizer", "fun", "status", "instance"]
        return pd.concat([frame.filter(names).astype(dict.fromkeys(names[:2], object)) for frame in frames])

    @cached_property
    def cost(self) -> str:
        """The cost of the missing controls, as a clause; "" where no control is missing.

        Such as ``"matched controls (bench run thesis --matched) would add 2,700 trials, about 4 min on 2 jobs"``. The
        time is the mean of the trials that each algorithm has made, and the number of jobs that of the last run.
        """
        results = self.trials.results
        study, frame = results.study, results.frame
        made = results.controls["optimizer"].value_counts()
        compared = {entry.label for entry in study.optimizers}
        controls = {
            entry.label: kind
            for same in self.matched
            for kind, entry in same.entries.items()
            if entry.label not in compared
        }
        lacking = {label: len(study.problems) * study.trials - int(made.get(label, 0)) for label in controls}
        total = sum(lacking.values())
        if not total:
            return ""
        kinds = frame["optimizer"].astype(object).map(algorithms(study))
        mean = pd.to_numeric(frame["wall_s"], errors="coerce").astype(float).groupby(kinds).mean()
        jobs = next((n for record in reversed(results.environments) if isinstance(n := record.get("jobs"), int)), 1)
        seconds = sum(number * mean.get(controls[label], math.nan) for label, number in lacking.items())
        time = "" if math.isnan(seconds) else f", about {duration(seconds / jobs)} on {count(jobs, 'job')}"
        name = study.name if study.name in registry.entries("studies") else "STUDY"
        return f"matched controls (bench run {name} --matched) would add {count(total, 'trial')}{time}"


def controls(findings: Findings) -> Controls:
    """Return the optimizers under each other's conditions, none of several folders."""
    several = len(findings.results.paths) > 1
    under = [] if several else matched(findings.study, findings.descriptions)
    return Controls(findings.trials, findings.final, under, findings.leader)
