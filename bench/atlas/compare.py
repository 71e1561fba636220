"""Test which implementations of a method differ, and measure how far.

Two implementations are *different* where their trials differ in at least one of ``MEASURES`` on at least one of
``PROBLEMS`` by the exact two-sample Kolmogorov-Smirnov test (:mod:`bench.analysis.kolmogorov_smirnov`), after Holm's
adjustment over all such tests of the atlas: pairs x functions x measures. No other test leads to that word. So in at
most 5% of atlases any pair that is one algorithm is called different, whatever the distributions, ties included.

The distances and the map are those of :mod:`bench.analysis.similarity`; no decision depends on them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, groupby
from math import comb

import numpy as np
import pandas as pd

from bench.analysis.direction import ALPHA
from bench.analysis.finished_trials import CLAMPED
from bench.analysis.kolmogorov_smirnov import ks_tests
from bench.analysis.pairwise import holm
from bench.analysis.similarity import Similarity, similarity
from bench.atlas.runs import MEASURES, Surveyed
from bench.check.bias import FLOOR, LIMIT, mean_log_error
from bench.errors import BenchError
from bench.helpers.text import count
from bench.typing import Floats

COLUMNS = ("method", "first", "second", "different", *MEASURES, "orders", "problem", "distance", "floor")
GROUPS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"


@dataclass(frozen=True)
class Atlas:
    """The findings of a survey.

    Attributes:
        surveyed: every implementation, in order.
        tests: method, first, second, problem, measure, ks_distance, p, p_holm, a row a test.
        pairs: method, first, second, ``different``; the number of problems with p_holm at most the level by measure;
            ``orders``, the largest difference of median final bests on those of measure ``final``, in orders of
            magnitude, positive where the first is lower, and ``problem``, where that is; and ``distance`` and ``floor``
            (:class:`bench.analysis.similarity.Similarity`), missing with fewer than ten trials.
        groups: by key, the letter of the group of an implementation: those of a method of which no two differ, each in
            the first group that takes it.
        similarity: of all implementations; None with fewer than two, or fewer than ten trials.
        enough: whether complete separation of one pair would be significant beside as many tests.
    """

    surveyed: tuple[Surveyed, ...]
    tests: pd.DataFrame
    pairs: pd.DataFrame
    groups: Mapping[str, str]
    similarity: Similarity | None
    enough: bool

    @property
    def counted(self) -> str:
        """How many pairs are different, as a sentence without its end."""
        different = int(self.pairs["different"].sum())
        verb = "is" if different == 1 else "are"
        return f"{different} of {count(len(self.pairs), 'pair')} of implementations of one method {verb} different"

    @property
    def doubt(self) -> str:
        """A sentence where the trials are too few for any difference, else ""."""
        few = not self.enough and len(self.pairs)
        return "So few trials can show no difference beside as many tests: take more." if few else ""


def compare(surveyed: Sequence[Surveyed], alpha: float = ALPHA, *, similar: bool = True) -> Atlas:
    """Compare the implementations of each method with each other.

    Args:
        surveyed: the implementations, those of one method side by side.
        alpha: the level of the tests.
        similar: whether to compute distances and the map, which takes most of the time.

    Raises:
        BenchError: where all implementations failed.
    """
    alive = [seen for seen in surveyed if not seen.failed]
    if not alive:
        reasons = [f"{seen.implementation.label}: {seen.failed}" for seen in surveyed]
        raise BenchError(f"no implementation could be run; {'; '.join(reasons[:1])}")
    couples = [
        couple
        for _, of_method in groupby(alive, lambda seen: seen.implementation.method)
        for couple in combinations(of_method, 2)
    ]
    tests = _tests(couples)
    trials = min((len(values) for seen in alive for values in seen.measures.values()), default=0)
    searches = None
    if similar and len(alive) > 1 and trials >= 10:
        # No test of it is used: with this level it makes the fewest divisions.
        searches = similarity({seen.implementation.key: [*seen.behaviours.values()] for seen in alive}, alpha=1.0)
    pairs = pd.DataFrame([_pair(*couple, tests, searches, alpha) for couple in couples], columns=list(COLUMNS))
    enough = 2 / comb(2 * trials, trials) * max(len(tests), 1) <= alpha
    return Atlas(tuple(surveyed), tests, pairs, _groups(alive, pairs), searches, enough)


def _tests(couples: Sequence[tuple[Surveyed, Surveyed]]) -> pd.DataFrame:
    """Return a row for each test of each pair, adjusted over all."""
    rows = []
    for one, rival in couples:
        names = one.implementation.method, one.implementation.label, rival.implementation.label
        for problem, these in one.measures.items():
            tested = ks_tests(these.T, rival.measures[problem].T)
            rows += [
                (*names, problem, measure, float(distance), float(p))
                for measure, distance, p in zip(MEASURES, tested["ks_distance"], tested["ks_p"], strict=True)
            ]
    columns = ["method", "first", "second", "problem", "measure", "ks_distance", "p"]
    frame = pd.DataFrame(rows, columns=columns)
    return frame.assign(p_holm=holm(frame["p"].to_numpy(dtype=float)))


def _pair(
    one: Surveyed, rival: Surveyed, tests: pd.DataFrame, searches: Similarity | None, alpha: float
) -> dict[str, object]:
    first, second = one.implementation, rival.implementation
    of_pair = (tests[["method", "first", "second"]] == [first.method, first.label, second.label]).all(axis=1)
    significant = tests[of_pair & (tests["p_holm"] <= alpha)]
    orders = {
        str(problem): _median_log(rival.measures[str(problem)]) - _median_log(one.measures[str(problem)])
        for problem in significant.loc[significant["measure"] == "final", "problem"]
    }
    where = max(orders, key=lambda problem: abs(orders[problem]), default="")
    row: dict[str, object] = {
        "method": first.method, "first": first.label, "second": second.label, "different": len(significant) > 0,
        "orders": orders.get(where, 0.0), "problem": where,
    }  # fmt: skip
    row |= {name: int((significant["measure"] == name).sum()) for name in MEASURES}
    if searches is not None:
        between = searches.pairs[(searches.pairs["first"] == first.key) & (searches.pairs["second"] == second.key)]
        row |= {name: float(between[name].iloc[0]) for name in ("distance", "floor")}
    return row


def _median_log(measures: Floats) -> float:
    """Return log10 of the median final best of (trials, measures), which counts as at least ``FLOOR``."""
    finals = np.nan_to_num(measures[:, MEASURES.index("final")], nan=np.inf, posinf=np.finfo(float).max)
    return float(np.log10(max(np.median(finals), FLOOR)))


def centre_bias(measures: Mapping[str, Floats]) -> float:
    """Return how many times as high errors are where the optimum is moved from the centre of the box; NaN without any.

    It is the geometric mean that :func:`bench.check.bias.centre_bias` judges; above ``LIMIT`` it is a bias.
    """
    logs = {problem: mean_log_error(values[:, MEASURES.index("final")]) for problem, values in measures.items()}
    functions = sorted({problem.rsplit(" ", 1)[0] for problem in logs})
    differences = [logs[f"{function} moved"] - logs[f"{function} centred"] for function in functions]
    return float(np.exp(np.mean(differences))) if differences else np.nan


def findings(seen: Surveyed) -> list[str]:
    """Return the findings on an implementation alone, in words: biases, parameters without effect, or its failure."""
    if seen.failed:
        return [f"failed: {seen.failed}"]
    sentences = []
    if (ratio := centre_bias(seen.measures)) > LIMIT:
        sentences.append(f"biased to the centre (errors are {ratio:.3g} times as high away from it)")
    if seen.clamped > CLAMPED:
        sentences.append(f"biased to the bounds ({seen.clamped:.0%} of the best points' coordinates lie on them)")
    if seen.dead:
        sentences.append("without effect: " + ", ".join(f"{name} (tried {tried})" for name, tried in seen.dead.items()))
    if not seen.repeatable:
        sentences.append("a seed does not repeat its runs")
    return sentences


def _groups(alive: Sequence[Surveyed], pairs: pd.DataFrame) -> dict[str, str]:
    """Return, for each implementation, the first letter that none of those before it has from which it differs."""
    different = pairs[pairs["different"].astype(bool)]
    groups: dict[str, str] = {}
    for entry in (seen.implementation for seen in alive):
        before = different[(different["method"] == entry.method) & (different["second"] == entry.label)]["first"]
        taken = {groups[replace(entry, label=label).key] for label in before}
        groups[entry.key] = next((letter for letter in GROUPS if letter not in taken), GROUPS[-1])
    return groups
