"""The facts of the answer: one optimizer against each rival, over these problems and on each of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from bench.analysis.comparison import compare, wins_all
from bench.analysis.ert_ratio import ert_ratios
from bench.analysis.pairwise import seen_from
from bench.topics.conditions.differing import Differing, differing
from bench.topics.findings import Findings

SHOWN = 10  # rivals of the figure, and of the ratios of running times


@dataclass(frozen=True)
class Facts:
    """The optimizer that the answer is about, the first one or the subject, against its rivals.

    Attributes:
        chosen: its label.
        is_subject: whether the study named it before the results.
        rivals: rows of :func:`bench.analysis.comparison.compare`, the best rivals first.
        first: the optimizers that share the first place.
        problems: on which every optimizer has runs.
        unlike: what may explain the outcome besides the algorithms.
    """

    chosen: str
    is_subject: bool
    rivals: pd.DataFrame
    first: tuple[str, ...]
    problems: tuple[str, ...]
    unlike: Differing

    @property
    def wins(self) -> bool:
        """Whether every test shows the chosen one to end lower."""
        return wins_all(self.rivals)

    @property
    def tested(self) -> bool:
        """Whether anything can be tested."""
        return bool(self.rivals["low"].notna().any())

    def of(self, outcome: str) -> list[str]:
        """Return the rivals of an outcome, the best first."""
        return list(self.rivals.loc[self.rivals["outcome"] == outcome, "rival"])

    @property
    def not_beaten(self) -> list[str]:
        """The rivals that the chosen one is not shown to beat, the best first."""
        return list(self.rivals.loc[self.rivals["outcome"] != "better", "rival"])

    @property
    def named(self) -> pd.DataFrame:
        """The rivals that a line names: the second; of a subject, the best that it loses to and that it beats."""
        if not self.is_subject:
            return self.rivals.head(1)
        outcome = self.rivals["outcome"]
        places = [np.flatnonzero(outcome == each)[:1] for each in ("worse", "better")]
        found = sorted(int(place[0]) for place in places if len(place))
        return self.rivals.iloc[found or [0]]


def facts(findings: Findings) -> Facts:
    """Return the facts on the subject of a study, or without one on the first optimizer."""
    table, chosen = findings.final.order, findings.leader
    rivals = compare(findings.trials.frame, chosen, before=bool(findings.subject)).set_index("rival")
    rivals = rivals.loc[[label for label in findings.final.ranked if label != chosen]].reset_index()
    better, worse = (list(rivals.loc[rivals["outcome"] == each, "rival"]) for each in ("better", "worse"))
    least = table["place"].min()
    return Facts(
        chosen,
        bool(findings.subject),
        rivals,
        tuple(table.loc[table["place"] == least, "optimizer"]),
        tuple(findings.final.medians.index),
        differing(findings, better if findings.subject else findings.final.ranked[1:], worse),
    )


def on_problems(findings: Findings) -> pd.DataFrame:
    """Return the outcome of the chosen optimizer on each problem, problems by rivals, by tests within the problem."""
    known = findings.of(facts)
    pairs = findings.final.pairs.astype({"first": object, "second": object, "lower": object})
    own = seen_from(pairs[pairs["problem"].isin(known.problems)], known.chosen)
    outcome = own["lower"].map(lambda lower: "better" if lower == known.chosen else "worse" if lower else "open")
    wide = own.assign(outcome=outcome).pivot(index="problem", columns="second", values="outcome")
    return wide.reindex(columns=list(known.rivals["rival"]))


def elsewhere(findings: Findings) -> dict[str, str]:
    """Return the dimensions of a suite in which another optimizer than the first has the highest chance."""
    known, chances = findings.of(facts), findings.final.chances
    size = chances["problem"].astype(object).map(findings.trials.dimensions)
    suite = set(findings.trials.suite_functions)
    if not set(known.problems) <= suite or size.nunique() < 2:
        return {}
    compared = chances[chances["problem"].isin(known.problems)]
    best = compared.groupby([size, "optimizer"], observed=True)["chance"].mean().unstack().idxmax(axis=1)
    firsts = zip(best.index, best.astype(str), strict=True)
    return {f"{dimension:g}": label for dimension, label in firsts if label != known.chosen}


def ratios(findings: Findings) -> pd.DataFrame:
    """Return how many times as many evaluations the best rivals need; no row where values alone are compared."""
    chosen, known = findings.anytime.target_set, findings.of(facts)
    if not chosen.absolute or not findings.trials.traces:
        return pd.DataFrame()
    hits = findings.anytime.tabled_hits
    hits = hits[np.isclose(hits["tau"].astype(float), chosen.level, rtol=1e-9, atol=0)]
    return ert_ratios(hits, known.chosen, [*dict.fromkeys([*known.named["rival"], *known.rivals["rival"][:SHOWN]])])


def own_seconds(findings: Findings) -> pd.Series[float]:
    """Return the seconds that a run of each optimizer takes besides those of the problem, where they are known."""
    table = findings.trials.timing.set_index("optimizer")
    return (table["wall_mean"] - table["objective_mean"]).dropna().clip(lower=0.0)
