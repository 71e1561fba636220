"""How alike optimizers search: distances between distributions of behaviour, a noise floor, a map and clusters.

The flood of metaheuristics named after metaphors asks whether a new one is new (Aranha, Camacho Villalón, Campelo,
Dorigo, Ruiz, Sevaux, Sörensen and Stützle 2022, Swarm Intelligence 16). Like Hayward and Engelbrecht (2023, IEEE
Transactions on Evolutionary Computation, doi:10.1109/tevc.2023.3346672) and Cenikj, Petelin and Eftimov (2025, GECCO
Companion, doi:10.1145/3712255.3726643), this looks at what an optimizer does, not only at how well it does:
a trial is described by numbers on results, trajectory and population in each eighth of its budget.

The distance of two optimizers is the Kolmogorov-Smirnov distance between their trials in each of these numbers,
averaged over numbers and problems: 0 alike, 1 nothing in common. Two samples of one optimizer are a positive distance
apart, the noise floor: the mean distance over divisions of the trials of a pair into two halves.

The p of a pair is the share of the divisions whose distance is at least the one found (Fisher 1935, The Design of
Experiments): of all divisions where they are few, else of random ones, the division found counted among them. Such a p
is never 0 and exceeds the level no more often than it should, whatever the distribution (Phipson and Smyth 2010,
Statistical Applications in Genetics and Molecular Biology 9). With few trials it cannot be small: of 5 against 5 trials
there are 126 divisions, so p is at least 1 / 126.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, count, pairwise
from math import ceil, comb

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.linalg import eigh
from scipy.spatial.distance import squareform

from bench.analysis.direction import ALPHA
from bench.analysis.pairwise import holm
from bench.errors import BenchError
from bench.typing import Floats

STAGES = 8  # equal parts of the budget
LEAST = 1e-12  # of logarithms: below it, differences are rounding
ON_BOUND = 1e-9  # of the box
SHUFFLES = 1_999  # at least; their p is a multiple of 1 / 2,000
MARGIN = 2  # times the shuffles that Holm's first step needs
AT_ONCE = 1_000  # divisions in memory
TRAITS = ("best", "median", "spread", "movement", "distance to best", "on bounds")
"""The numbers of a stage: log10 of the precision reached, of the median precision of the points evaluated, of their
spread, of the movement of their centre, and of their mean distance to the best point so far; and the share of
coordinates on or beyond a bound. Lengths are shares of the box."""


@dataclass(frozen=True)
class Similarity:
    """How alike optimizers are.

    Attributes:
        distances: mean KS distances, optimizers by optimizers; on the diagonal, each one against itself.
        pairs: first, second, distance, ``floor`` (the mean over divisions), p, p_holm, adjusted over the pairs (Holm
            1979), and alike: not separable at the level.
        least: the least p that a pair can have with so many trials.
        needed: the trials from which on a pair can be separable at the level; with fewer, every pair is alike.
        clusters: the number of the cluster of each optimizer, from 1 in their order: groups of which no two are
            separable (complete linkage).
        tree: the average linkage of :mod:`scipy.cluster.hierarchy`, over distances less their floors.
        places: coordinates of each optimizer on a map (classical scaling of the distances less their floors).
        stress: the share of the squared distances that the map does not show.
    """

    distances: pd.DataFrame
    pairs: pd.DataFrame
    least: float
    needed: int
    clusters: pd.Series[int]
    tree: Floats
    places: pd.DataFrame
    stress: float


def behaviour(points: Floats, values: Floats, optimum: float, budget: int) -> Floats:
    """Return (stages * traits,) numbers of one trial.

    Args:
        points: (n, d) the points evaluated, in order, as shares of the box.
        values: (n,) their values.
        optimum: from which precisions are counted.
        budget: the evaluations allowed; a trial that ended early keeps the numbers of its last stage.
    """
    above = np.maximum(np.where(np.isfinite(values), values, np.inf) - optimum, LEAST)
    lowest = np.minimum.accumulate(above)
    leader = np.maximum.accumulate(np.where(np.append(True, lowest[1:] < lowest[:-1]), np.arange(len(above)), 0))
    ends = np.minimum(np.rint(np.linspace(0, budget, STAGES + 1)).astype(int), len(points))
    centre, rows = np.full(points.shape[1], 0.5), []
    for start, end in pairwise(ends):
        if start < end:
            of_run = points[start:end]
            middle = of_run.mean(axis=0)
            away = np.linalg.norm(of_run - points[leader[end - 1]], axis=1).mean()
            lengths = of_run.std(axis=0).mean(), np.linalg.norm(middle - centre), away
            edges = ((of_run <= ON_BOUND) | (of_run >= 1 - ON_BOUND)).mean()
            logs = np.log10(np.maximum([lowest[end - 1], np.median(above[start:end]), *lengths], LEAST))
            row = np.append(np.minimum(logs, -2 * np.log10(LEAST)), edges)
            centre = middle
        rows.append(row)  # the first stage has a point: every trial has one
    return np.concatenate(rows)


def similarity(behaviours: Mapping[str, Sequence[Floats]], alpha: float = ALPHA, seed: int = 0) -> Similarity:
    """Compare optimizers by the behaviour of their trials.

    Args:
        behaviours: by optimizer, an array of (trials, numbers) for each problem, in the same order of problems. The
            first half of the trials is compared with those of others, the second half with the first.
        alpha: the level of the tests.
        seed: repeats the random divisions.

    Raises:
        BenchError: for fewer than two optimizers or problems, or fewer than ten trials.
    """
    names = list(behaviours)
    if len(names) < 2:
        raise BenchError("similarity needs at least two optimizers")
    trials = min((len(numbers) for by_problem in behaviours.values() for numbers in by_problem), default=0)
    if trials < 10:
        raise BenchError(
            f"similarity needs at least 10 trials of each optimizer, half of them against itself, not {trials}"
        )
    half = trials // 2
    stacked = {
        name: np.concatenate([numbers[:trials].T for numbers in by_problem]) for name, by_problem in behaviours.items()
    }
    distances = pd.DataFrame(0.0, index=names, columns=names)
    itself = np.arange(2 * half)[np.newaxis] < half
    for name, numbers in stacked.items():
        distances.loc[name, name] = _distances(numbers[:, : 2 * half], itself)[0]
    number = len(names) * (len(names) - 1) // 2
    divided = _divisions(half, max(SHUFFLES, ceil(MARGIN * number / alpha) - 1), np.random.default_rng(seed))
    rows = []
    for one, other in combinations(names, 2):
        between = _distances(np.concatenate((stacked[one][:, :half], stacked[other][:, :half]), axis=1), divided)
        distances.loc[one, other] = distances.loc[other, one] = between[0]
        rows.append((one, other, between[0], between.mean(), (between >= between[0]).mean()))
    pairs = pd.DataFrame(rows, columns=["first", "second", "distance", "floor", "p"])
    pairs["p_holm"] = holm(pairs["p"].to_numpy(dtype=float))
    pairs["alike"] = pairs["p_holm"] > alpha
    apart = pairs["p"].rank(ascending=False, method="min").to_numpy(dtype=float) + len(pairs) * ~pairs["alike"]
    groups = fcluster(linkage(apart, method="complete"), len(pairs), criterion="distance")
    excess = np.maximum((pairs["distance"] - pairs["floor"]).to_numpy(dtype=float), 0.0)
    places, stress = _map(squareform(excess))
    return Similarity(
        distances=distances,
        pairs=pairs,
        least=1 / len(divided),
        needed=2 * next(size for size in count(5) if number <= alpha * comb(2 * size, size) / 2),
        clusters=pd.Series(pd.factorize(groups)[0] + 1, index=names),
        tree=linkage(excess, method="average"),
        places=pd.DataFrame(places, index=names, columns=["x", "y"]),
        stress=stress,
    )


def _divisions(half: int, most: int, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Return divisions of twice ``half`` trials into two halves, (divisions, 2 * half), the given one first.

    They are all divisions where these are no more than ``most``, and else so many random ones beside the given one. The
    halves have no order: which of them is true means nothing.
    """
    if comb(2 * half, half) // 2 > most:
        ranks = rng.random((most, 2 * half)).argsort(axis=1)
        return np.concatenate((np.arange(2 * half)[np.newaxis], ranks)) < half
    chosen = np.array(list(combinations(range(1, 2 * half), half - 1)))  # of the half that holds the first trial
    divided = np.zeros((len(chosen), 2 * half), dtype=bool)
    divided[:, 0] = True
    np.put_along_axis(divided, chosen, True, axis=1)
    return divided


def _distances(values: Floats, divided: NDArray[np.bool_]) -> Floats:
    """Return the mean KS distance between two halves of the trials for each division, (divisions,).

    The mean is over whole numbers, so that equal distances are equal to the last bit.

    Args:
        values: (numbers, trials).
        divided: (divisions, trials), which trials are of the first half.
    """
    order = values.argsort(axis=1)
    values = np.take_along_axis(values, order, axis=1)
    last = np.pad(values[:, 1:] != values[:, :-1], ((0, 0), (0, 1)), constant_values=True)  # tied values are one step
    half = values.shape[1] // 2
    kind = np.int8 if half <= np.iinfo(np.int8).max else np.int32  # small numbers are several times as fast
    distances = np.empty(len(divided))
    for start in range(0, len(divided), AT_ONCE):
        steps = np.where(divided[start : start + AT_ONCE].T, 1, -1).astype(kind)
        above = np.zeros((len(values), steps.shape[1]), dtype=kind)  # trials of the first half less those of the other
        furthest, reached = above.copy(), above.copy()
        for place, ends in zip(order.T, last.T, strict=True):
            above += np.take(steps, place, axis=0, out=reached, mode="clip")
            np.abs(above, out=reached)
            if not ends.all():
                reached *= ends[:, np.newaxis]
            np.maximum(furthest, reached, out=furthest)
        distances[start : start + AT_ONCE] = furthest.sum(axis=0, dtype=np.int64) / (half * len(values))
    return distances


def _map(distances: Floats) -> tuple[Floats, float]:
    """Return (n, 2) coordinates by classical scaling (Torgerson 1952), and the share of squares that they leave out."""
    n = len(distances)
    centring = np.eye(n) - 1 / n
    values, vectors = eigh(-centring @ distances**2 @ centring / 2)
    places = vectors[:, ::-1][:, :2] * np.sqrt(np.maximum(values[::-1][:2], 0.0))
    shown = np.linalg.norm(places[:, np.newaxis] - places, axis=2)
    whole = float((distances**2).sum())
    places *= np.where(places[np.abs(places).argmax(axis=0), [0, 1]] < 0, -1.0, 1.0)  # the sign is arbitrary
    return np.asarray(places, dtype=np.float64), float(((distances - shown) ** 2).sum() / whole) if whole else 0.0
