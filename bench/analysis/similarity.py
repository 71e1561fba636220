"""How alike optimizers search: distances between distributions of behaviour, a noise floor, a map and clusters.

The flood of metaheuristics named after metaphors asks whether a new one is new (Aranha, Camacho Villalón, Campelo,
Dorigo, Ruiz, Sevaux, Sörensen and Stützle 2022, Swarm Intelligence 16). Like Hayward and Engelbrecht (2023, IEEE
Transactions on Evolutionary Computation, doi:10.1109/tevc.2023.3346672) and Cenikj, Petelin and Eftimov (2025, GECCO
Companion, doi:10.1145/3712255.3726643), this looks at what an optimizer does, not only at how well it does:
a trial is described by numbers on results, trajectory and population in each eighth of its budget.

The distance of two optimizers is the Kolmogorov-Smirnov distance between their trials in each of these numbers,
averaged over numbers and problems: 0 alike, 1 nothing in common. Two samples of one optimizer are a positive distance
apart, the noise floor. Shuffling the trials of a pair between the two shows how far chance moves it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np
import pandas as pd
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.linalg import eigh
from scipy.spatial.distance import squareform
from scipy.stats import norm

from bench.analysis.pairwise import ALPHA, holm, ks_distance
from bench.errors import BenchError
from bench.problem import Floats

STAGES = 8  # equal parts of the budget
LEAST = 1e-12  # of logarithms: below it, differences are rounding
ON_BOUND = 1e-9  # of the box
SHUFFLES = 200
TRAITS = ("best", "median", "spread", "movement", "distance to best", "on bounds")
"""The numbers of a stage: log10 of the precision reached, of the median precision of the points evaluated, of their
spread, of the movement of their centre, and of their mean distance to the best point so far; and the share of
coordinates on or beyond a bound. Lengths are shares of the box."""


@dataclass(frozen=True)
class Similarity:
    """How alike optimizers are.

    Attributes:
        distances: mean KS distances, optimizers by optimizers; on the diagonal, each one against itself.
        pairs: first, second, distance, ``floor`` (the mean over shuffles), p, p_holm, adjusted over the pairs (Holm
            1979), and alike: not separable at the level.
        clusters: the number of the cluster of each optimizer, from 1 in their order: groups of which no two are
            separable (complete linkage).
        tree: the average linkage of :mod:`scipy.cluster.hierarchy`, over distances less their floors.
        places: coordinates of each optimizer on a map (classical scaling of the distances less their floors).
        stress: the share of the squared distances that the map does not show.
    """

    distances: pd.DataFrame
    pairs: pd.DataFrame
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
            own = points[start:end]
            middle = own.mean(axis=0)
            away = np.linalg.norm(own - points[leader[end - 1]], axis=1).mean()
            lengths = own.std(axis=0).mean(), np.linalg.norm(middle - centre), away
            edges = ((own <= ON_BOUND) | (own >= 1 - ON_BOUND)).mean()
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
        seed: repeats the shuffles.

    Raises:
        BenchError: for fewer than two optimizers or problems, or fewer than ten trials.
    """
    names = list(behaviours)
    if len(names) < 2:
        raise BenchError("similarity needs at least two optimizers")
    trials = min((len(own) for each in behaviours.values() for own in each), default=0)
    if trials < 10:
        raise BenchError(
            f"similarity needs at least 10 trials of each optimizer, half of them against itself, not {trials}"
        )
    half = trials // 2
    stacked = {name: np.concatenate([own[:trials].T for own in each]) for name, each in behaviours.items()}
    first = {name: own[:, :half] for name, own in stacked.items()}
    distances = pd.DataFrame(0.0, index=names, columns=names)
    for name, own in stacked.items():
        distances.loc[name, name] = _distance(own[:, :half], own[:, half : 2 * half])
    rng, rows = np.random.default_rng(seed), []
    for one, other in combinations(names, 2):
        found = _distance(first[one], first[other])
        distances.loc[one, other] = distances.loc[other, one] = found
        rows.append((one, other, found, *_chance(first[one], first[other], rng)))
    pairs = pd.DataFrame(rows, columns=["first", "second", "distance", "floor", "deviation"])
    distance, floor, deviation = (pairs[each].to_numpy(dtype=float) for each in ("distance", "floor", "deviation"))
    sizes = (distance - floor) / np.where(deviation > 0, deviation, np.inf)
    pairs = pairs.assign(p=norm.sf(sizes))
    pairs["p_holm"] = holm(pairs["p"].to_numpy(dtype=float))
    pairs["alike"] = pairs["p_holm"] > alpha
    apart = pairs["p_holm"].rank(ascending=False, method="min").to_numpy(dtype=float) + len(pairs) * ~pairs["alike"]
    groups = fcluster(linkage(apart, method="complete"), len(pairs), criterion="distance")
    excess = np.maximum(distance - floor, 0.0)
    places, stress = _map(squareform(excess))
    return Similarity(
        distances=distances,
        pairs=pairs.drop(columns="deviation"),
        clusters=_renumbered(pd.Series(groups, index=names)),
        tree=linkage(excess, method="average"),
        places=pd.DataFrame(places, index=names, columns=["x", "y"]),
        stress=stress,
    )


def _distance(one: Floats, other: Floats) -> float:
    """Return the mean KS distance over the rows of two arrays of (numbers, trials)."""
    return float(ks_distance(one, other).mean())


def _chance(one: Floats, other: Floats, rng: np.random.Generator) -> tuple[float, float]:
    """Return mean and standard deviation of the distance when the trials are shuffled, problem by problem alike."""
    both = np.concatenate((one, other), axis=1)
    found = []
    for _ in range(SHUFFLES):
        order = rng.permutation(both.shape[1])
        found.append(_distance(both[:, order[: one.shape[1]]], both[:, order[one.shape[1] :]]))
    return float(np.mean(found)), float(np.std(found, ddof=1))


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


def _renumbered(clusters: pd.Series[int]) -> pd.Series[int]:
    """Return clusters numbered by their first member."""
    order = {cluster: number for number, cluster in enumerate(dict.fromkeys(clusters), 1)}
    return clusters.map(order).astype(int)
