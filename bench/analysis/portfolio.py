"""Which optimizers a set of problems needs: virtual and single best, the smallest set near the former, Shapley values.

The score of a trial is the share of its problem's targets that it reached within the budget, where its runtime
distribution ends (Hansen et al. 2016, arXiv:1605.03560): targets are in steps of a logarithm, so that problems of any
scale count alike, and a trial that failed or found only infinite values has 0.

The *virtual best* takes the best optimizer for each problem, the *single best* one optimizer for all (Rice 1976,
Advances in Computers 15; Kerschke, Hoos, Neumann and Trautmann 2019, Evolutionary Computation 27). Chosen and scored
on the same trials, the virtual best of equal optimizers beats the single best by chance alone. Here half of the trials
choose, the others score, and both halves change places, for several divisions into halves. With less data to choose
by, the gap is too small rather than too large. Every function counts once, however many dimensions of it there are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from bench.analysis.cells import labels
from bench.analysis.direction import ALPHA
from bench.errors import BenchError
from bench.typing import Floats

SPLITS = 10  # divisions of the trials into halves, each used both ways
SEED = 1
MOST_EXACT = 12  # optimizers all of whose sets are compared: 4,096 of them
NEAR = 0.95  # of the score of the virtual best
ROUNDING = 12  # decimals of scores: sums of equal numbers in another order differ by rounding


class Portfolio(NamedTuple):
    """The worth of a portfolio of all optimizers on these problems.

    Attributes:
        gap: one row: ``single``, the label of the single best; ``problems``, ``functions``; ``single_score`` and
            ``virtual_score``; ``gap``, their difference, with its interval ``low`` and ``high`` over functions
            (Student's, missing with one function); and ``shown``, whether that lies above 0.
        sets: size, optimizers (a tuple), ``score`` and ``ratio``, over the score of the virtual best, of the best set
            of each size, up to the first whose ratio is at least 0.95. All sets of a size were compared, or with more
            than 12 optimizers those with one more than the set before.
        members: optimizer, ``score`` (it alone), ``chosen`` (the share of problems for which the virtual best takes
            it; a tie is divided), ``shapley``, and ``adds``: how much lower the score of the virtual best is without
            this optimizer.
    """

    gap: pd.DataFrame
    sets: pd.DataFrame
    members: pd.DataFrame


def target_shares(
    hits: pd.DataFrame, budget: Mapping[str, int], charge: Mapping[str, int] | None = None
) -> pd.DataFrame:
    """Return the score of each trial, the share of targets reached within the budget: problem, optimizer, trial, score.

    Args:
        hits: those of :func:`bench.analysis.hitting_times`.
        budget: the evaluations that count, by problem; other problems are left out.
        charge: evaluations of it that are spent before the search begins, by problem.
    """
    counted = hits[hits["problem"].astype(object).isin(list(budget))].astype({"problem": object})
    before = counted["problem"].map(charge or {}).fillna(0.0).astype(float)
    within = counted["evaluations"].astype(float) <= counted["problem"].map(budget).astype(float) - before
    groups = within.groupby([counted["problem"], counted["optimizer"], counted["trial"]], sort=False, observed=True)
    return groups.mean().round(ROUNDING).rename("score").reset_index()


def portfolio_of(scores: pd.DataFrame, blocks: Mapping[str, str], seed: int = SEED) -> Portfolio:
    """Return the gap between virtual and single best, the best sets, and what each optimizer contributes.

    Problems on which an optimizer has fewer than two trials are left out.

    Args:
        scores: those of :func:`target_shares`, or others of which larger is better and 0 is nothing.
        blocks: the function of each problem; functions are what the interval treats as independent.
        seed: repeats the halves.

    Raises:
        BenchError: where no problem is left.
    """
    halves = HalfScores.of(scores, blocks, seed)
    return Portfolio(best_gap(halves), _best_sets(halves), _members(halves))


def student(values: Sequence[float] | Floats, alpha: float = ALPHA) -> tuple[float, float, float]:
    """Return the mean of independent values and Student's interval; its ends are missing for one value."""
    sample = np.asarray(values, dtype=np.float64)
    mean = float(sample.mean())
    if len(sample) < 2:
        return mean, np.nan, np.nan
    reach = float(stdtrit(len(sample) - 1, 1 - alpha / 2) * sample.std(ddof=1) / np.sqrt(len(sample)))
    return mean, mean - reach, mean + reach


def over_functions(values: Any, blocks: Mapping[str, str]) -> Any:
    """Return the mean over each function's problems, of a Series or the columns of a DataFrame by problem."""
    return values.groupby([blocks.get(str(problem), str(problem)) for problem in values.index], sort=False).mean()


@dataclass(frozen=True)
class HalfScores:
    """The mean scores of P problems and K optimizers on two halves of the trials, H times.

    Attributes:
        choose: (H, P, K), the half that chooses; score: (H, P, K), the other half.
        whole: (P, K), of all trials.
        weights: (P,), of the problems: each function has the same weight, and their sum is 1.
    """

    problems: list[str]
    optimizers: list[str]
    blocks: Mapping[str, str]
    choose: Floats
    score: Floats
    whole: Floats
    weights: Floats

    @classmethod
    def of(cls, scores: pd.DataFrame, blocks: Mapping[str, str], seed: int = SEED) -> HalfScores:
        """Divide the trials of each problem, those of the same number alike for all optimizers.

        Raises:
            BenchError: where there is no problem on which every optimizer has two trials.
        """
        optimizers, rng = labels(scores, "optimizer"), np.random.default_rng(seed)
        plain = scores.astype({"problem": object, "optimizer": object})
        wide = plain.pivot(index=["problem", "trial"], columns="optimizer", values="score").reindex(columns=optimizers)
        order = dict.fromkeys(plain["problem"])
        enough = wide.groupby(level="problem").count().min(axis=1) >= 2
        tables = {problem: wide.loc[problem].sort_index() for problem in order if enough[problem]}
        if not tables:
            raise BenchError("there is no problem on which every optimizer has two trials, so none can be chosen")
        choose, score = np.empty((2, 2 * SPLITS, len(tables), len(optimizers)))
        for place, table in enumerate(tables.values()):
            values = table.to_numpy(dtype=float)
            for split in range(SPLITS):
                first, second = _halves(values[rng.permutation(len(values))])
                choose[2 * split, place], score[2 * split, place] = first, second
                choose[2 * split + 1, place], score[2 * split + 1, place] = second, first
        sizes = pd.Series([blocks.get(problem, problem) for problem in tables]).value_counts()
        weights = [1 / (len(sizes) * sizes[blocks.get(problem, problem)]) for problem in tables]
        whole = np.array([table.mean().to_numpy(dtype=float) for table in tables.values()])
        held = list(tables)
        return cls(held, optimizers, blocks, choose.round(ROUNDING), score, whole.round(ROUNDING), np.array(weights))

    def chosen(self, members: Sequence[int]) -> Floats:
        """Return the share of each of these optimizers in what a set of them takes, (H, P, members); ties are equal."""
        choosing = self.choose[..., list(members)]
        best = choosing == choosing.max(axis=-1, keepdims=True)
        shares: Floats = best / best.sum(axis=-1, keepdims=True)
        return shares

    def scores_of(self, members: Sequence[int]) -> Floats:
        """Return the score of a set of optimizers on each problem, (P,)."""
        scores: Floats = (self.chosen(members) * self.score[..., list(members)]).sum(axis=-1).mean(axis=0)
        return scores

    def value(self, members: Sequence[int]) -> float:
        """Return the mean score of a set of optimizers over functions, 0 of none."""
        return round(float(self.scores_of(members) @ self.weights), ROUNDING) if len(members) else 0.0


def _halves(values: Floats) -> tuple[Floats, Floats]:
    """Return the mean of the first half of each column's values, and that of the others; missing ones are no trial."""
    held = ~np.isnan(values)
    first = held & (held.cumsum(axis=0) <= held.sum(axis=0) // 2)
    return values.mean(axis=0, where=first), values.mean(axis=0, where=held & ~first)


def best_gap(halves: HalfScores) -> pd.DataFrame:
    """Return the gap between virtual and single best, as in :class:`Portfolio`; both are chosen by the other half."""
    everyone = range(len(halves.optimizers))
    picked = (halves.weights[:, np.newaxis] * halves.choose).sum(axis=1).round(ROUNDING).argmax(axis=1)  # (H,)
    single = np.take_along_axis(halves.score, picked[:, np.newaxis, np.newaxis], axis=2)[..., 0].mean(axis=0)
    virtual = halves.scores_of(everyone)
    apart = pd.Series(virtual - single, index=halves.problems).round(ROUNDING)
    by_function = over_functions(apart, halves.blocks)
    gap, low, high = student(by_function.to_list())
    means = (halves.weights[:, np.newaxis] * halves.whole).sum(axis=0).round(ROUNDING)
    row = {
        "single": halves.optimizers[int(means.argmax())],
        "problems": len(halves.problems),
        "functions": len(by_function),
        "single_score": float(single @ halves.weights),
        "virtual_score": float(virtual @ halves.weights),
        "gap": gap, "low": low, "high": high, "shown": bool(low > 0),
    }  # fmt: skip
    return pd.DataFrame([row])


def _best_sets(halves: HalfScores) -> pd.DataFrame:
    """Return the best set of each size, of all sets or, for many optimizers, by adding one, until a set is near."""
    everyone = range(len(halves.optimizers))
    virtual = halves.value(everyone)
    members: tuple[int, ...] = ()
    rows: list[tuple[Any, ...]] = []
    while not rows or halves.value(members) < NEAR * virtual:
        adding = [(*members, member) for member in everyone if member not in members]
        few = len(everyone) <= MOST_EXACT
        members = max(combinations(everyone, len(members) + 1) if few else adding, key=halves.value)
        score = halves.value(members)
        names = tuple(halves.optimizers[member] for member in members)
        rows.append((len(members), names, score, score / virtual if virtual > 0 else 1.0))
    return pd.DataFrame(rows, columns=["size", "optimizers", "score", "ratio"])


def _members(halves: HalfScores) -> pd.DataFrame:
    everyone = list(range(len(halves.optimizers)))
    virtual = halves.value(everyone)
    worth = [shapley(choose, score) for choose, score in zip(halves.choose, halves.score, strict=True)]
    without = [halves.value([left for left in everyone if left != member]) for member in everyone]
    return pd.DataFrame(
        {
            "optimizer": halves.optimizers,
            "score": [halves.value([member]) for member in everyone],
            "chosen": (halves.chosen(everyone).mean(axis=0) * halves.weights[:, np.newaxis]).sum(axis=0),
            "shapley": (halves.weights @ np.mean(worth, axis=0)).round(ROUNDING),
            "adds": np.subtract(virtual, without).round(ROUNDING),
        }
    )


def shapley(choose: Floats, score: Floats) -> Floats:
    """Return the Shapley values of optimizers on each problem, (P, K): what one adds, averaged over all orders.

    A set of optimizers takes the one with the highest ``choose`` and is worth its ``score``, the mean of those that
    tie; both are (P, K). That of a portfolio is by Fréchette, Kotthoff, Michalak, Rahwan, Hoos and Leyton-Brown (2016,
    AAAI). Here no sets are needed. With t better ones and g that tie, itself among them, an optimizer comes before all
    better and tied ones in 1 of t + g orders, and then adds the mean score of those that tie. Its own score differs
    from that mean, and counts more where it comes before some of them: by the mean of 1/(t + 1) to 1/(t + g - 1).
    It takes the place of a worse one, whose t and g count here, in 1 of t (t + g) orders.
    """
    better = choose[:, np.newaxis] > choose[..., np.newaxis]  # (P, K, K): the third is better than the second
    equal = choose[:, np.newaxis] == choose[..., np.newaxis]
    above, tied = better.sum(axis=-1), equal.sum(axis=-1)
    inverse = np.concatenate(([0.0], (1 / np.arange(1, choose.shape[-1] + 1)).cumsum()))
    mean = (equal * score[:, np.newaxis]).sum(axis=-1) / tied
    apart = (inverse[above + tied - 1] - inverse[above]) / np.maximum(tied - 1, 1)
    replaced = (better * (score / (np.maximum(above, 1) * (above + tied)))[..., np.newaxis]).sum(axis=1)
    values: Floats = mean / (above + tied) + (score - mean) * apart - replaced
    return values
