"""Compare optimizers at declared looks: which pairs are decided there, and which cells therefore need no more trials.

On each problem all pairs are tested at every look that their trials have reached, by the test of
:func:`bench.analysis.pairwise_tests`. The level is spent over the looks (:mod:`bench.analysis.sequential`): a pair has
the smallest of its repeated p-values so far, and Holm's method adjusts these over all pairs of the problem, at alpha
over the number of problems. A pair is *decided* where the result is at most that; a pair that is decided stays so. A
cell is *stopped* at the first look at which all of its pairs are decided. Everything follows from the trials before the
look, whoever asks, and whenever.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from bench.analysis.cells import cells, labels
from bench.analysis.direction import ALPHA, effects, least_p, p_values
from bench.analysis.pairwise import adjusted, alike, holm
from bench.analysis.sequential import repeated_p

COLUMNS = ("problem", "first", "second", "look", "p")


@dataclass(frozen=True)
class Decisions:
    """The outcome of the looks so far.

    Attributes:
        stopped: the number of trials at which each cell (problem, optimizer) was stopped; others are not in it.
        pairs: a row a problem and pair: problem, first, second, p, the smallest repeated p-value, and look, the number
            of trials at the look that it is of; 1 and 0 before the first look.
        reached: by problem, the last look that all cells not stopped before have reached, 0 before the first.
    """

    stopped: Mapping[tuple[str, str], int]
    pairs: pd.DataFrame
    reached: Mapping[str, int]


def decide(frame: pd.DataFrame, looks: Sequence[int], alpha: float = ALPHA) -> Decisions:
    """Decide at each look which cells need no more trials.

    Args:
        frame: the tidy frame, or its columns problem, optimizer, trial, status and fun. A look counts for a cell
            once all of its trials before it are there; failed ones count as +inf.
        looks: the numbers of trials at which the optimizers are compared, increasing.
        alpha: the level over all looks, pairs and problems.
    """
    if not looks:
        return Decisions({}, pd.DataFrame(columns=list(COLUMNS)), {})
    by_look = [cells(frame[frame["trial"] < look], merge=True) for look in looks]
    optimizers = labels(frame, "optimizer")
    one, other = np.triu_indices(len(optimizers), 1)
    names = np.array(optimizers, dtype=object)
    stopped: dict[tuple[str, str], int] = {}
    reached, tables = {}, []
    problems = labels(frame, "problem")
    level = alpha / max(len(problems), 1)
    for problem in problems:
        p, look_of, ends = np.ones(len(one)), np.zeros(len(one), dtype=np.int64), np.zeros(len(names), dtype=np.int64)
        reached[problem] = 0
        for place, look in enumerate(looks):
            samples = [by_look[place].get((problem, name), np.empty(0)) for name in optimizers]
            there = np.array([len(sample) == look for sample in samples], dtype=bool)
            active = there & (ends == 0)
            tested = np.flatnonzero(active[one] & active[other])
            p_now = np.ones(len(tested))
            for part, these, others in alike([samples[cell] for cell in np.flatnonzero(active)]):
                p_now[part] = p_values(effects(these, others))
            now = repeated_p(p_now, looks, place)
            better = now < p[tested]
            p[tested[better]], look_of[tested[better]] = now[better], look
            still_open = holm(p) > level
            active[one[still_open]] = active[other[still_open]] = False
            ends[active] = look
            if (there | (ends > 0)).all():
                reached[problem] = look
        stopped |= {(problem, name): int(end) for name, end in zip(optimizers, ends, strict=True) if end}
        key = {"problem": np.full(len(one), problem, dtype=object), "first": names[one], "second": names[other]}
        tables.append(pd.DataFrame(key | {"look": look_of, "p": p}))
    pairs = pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=list(COLUMNS))
    return Decisions(stopped, pairs[list(COLUMNS)], reached)


def blind_looks(looks: Sequence[int], tests: int = 1, alpha: float = ALPHA) -> list[int]:
    """Return the looks that can decide nothing, as not even complete separation of two cells is significant there.

    ``tests`` is the number of pairs of optimizers times that of problems.
    """
    least = [repeated_p(least_p(look), looks, place) for place, look in enumerate(looks)]
    return [look for look, p in zip(looks, least, strict=True) if p * tests > alpha]


def at_looks(pairs: pd.DataFrame, decisions: Decisions, alpha: float = ALPHA) -> pd.DataFrame:
    """Return the rows of :func:`bench.analysis.pairwise_tests` with the p-values of the looks, adjusted likewise.

    A column ``look`` has the number of trials at the look that p is of. A pair that has reached no look has p = 1.
    Trials stop where the difference looks large, so A12 of a pair with a stopped cell is biased away from 0.5: it
    has a rank only, and no interval (``stopped``).
    """
    keys = ["problem", "first", "second"]
    decided = pairs[keys].astype(object).merge(decisions.pairs, on=keys, how="left")
    stopped = np.zeros(len(pairs), dtype=bool)
    for name in ("first", "second"):
        cells_of = zip(pairs["problem"], pairs[name], strict=True)
        stopped |= np.array([cell in decisions.stopped for cell in cells_of], dtype=bool)
    ends = ["a12_low", "a12_high", "joint_low", "joint_high"]
    unknown = {name: pairs[name].mask(stopped) for name in ends}
    return adjusted(
        pairs.assign(p=decided["p"].to_numpy(), look=decided["look"].to_numpy(), stopped=stopped, **unknown), alpha
    )
