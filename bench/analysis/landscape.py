"""Cheap features of a problem's landscape, from a sample of points and their values (exploratory landscape analysis).

Names and definitions are those of flacco (Kerschke and Trautmann 2019, in: Applications in Statistical Computing):

- ``ela_distr``: skewness, excess kurtosis and peaks of the distribution of values (Mersmann, Bischl, Trautmann, Preuss,
  Weihs and Rudolph 2011, GECCO);
- ``ela_meta``: how well linear and quadratic models fit, adjusted for their size, and their coefficients (ibid.);
- ``disp``: how far the best points lie apart, over the distance of all points (Lunacek and Whitley 2006, GECCO);
- ``nbc``: the nearest better against the nearest neighbour (Kerschke, Preuss, Wessing and Trautmann 2015, GECCO);
- ``ic``: information content of a walk to the nearest point not visited (Muñoz, Kirley and Halgamuge 2015, IEEE
  Transactions on Evolutionary Computation 19);
- ``fitness_distance``: the correlation of value and distance to the best point (Jones and Forrest 1995, ICGA).

Points are scaled to the unit cube and values to 0 … 1, so that no feature depends on units (Prager and Trautmann 2023,
EvoApplications). Features describe the sample: those of another sample of the same problem differ a little.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.spatial.distance import cdist, pdist
from scipy.stats import gaussian_kde, kurtosis, qmc, rankdata, skew

from bench.analysis.direction import ALPHA
from bench.errors import BenchError
from bench.problem import Problem
from bench.typing import Floats

POINTS = 250  # a dimension
MOST_POINTS = 4_000  # distances between all of them are held
LEAST_POINTS = 30
MOST_COLUMNS = 500  # of a model; those with interactions are left out in high dimensions, as they would take a minute
QUANTILES = (0.02, 0.05, 0.10, 0.25)  # of the best points whose dispersion is measured
PEAK = 0.01  # the least share of the values that makes a peak
SETTLED, HALF = 0.05, 0.5  # of the information content, and of the initial partial information
EPSILONS = np.concatenate(([0.0], np.geomspace(1e-5, 1e15, 1000)))  # differences over distances that count as equal
LEAST_PROBLEMS = 10  # for which features are compared with ranks
EXCHANGES = 1000  # of the features of blocks, the given order among them
AT_ONCE = 100  # exchanges
SEED = 1


def describe(problem: Problem, points: int | None = None, seed: int = 0) -> dict[str, float]:
    """Return the features of a problem by name, from a Latin hypercube of its box.

    Whole-number variables are rounded, noisy problems are described by their true values, and constraints are not
    looked at. A feature that the sample does not define is missing (NaN).

    Args:
        problem: the problem, whose ``evaluate`` is called once.
        points: the size of the sample; by default 250 a dimension, at most 4,000.
        seed: repeats the sample.

    Raises:
        BenchError: for fewer than 30 points, or where fewer than 30 have a finite value or all have the same one.
    """
    number = default_points(problem.dimension) if points is None else points
    if number < LEAST_POINTS:
        raise BenchError(f"a sample needs at least {LEAST_POINTS} points, not {number}")
    unit = qmc.LatinHypercube(problem.dimension, rng=np.random.default_rng(seed)).random(number)
    x = problem.lower + unit * (problem.upper - problem.lower)
    if problem.integer is not None:
        x = np.where(problem.integer, np.rint(x), x)
        unit = (x - problem.lower) / (problem.upper - problem.lower)
    y = np.asarray(problem.noiseless(x), dtype=float)
    finite = np.isfinite(y)
    if finite.sum() < LEAST_POINTS:
        raise BenchError(
            f"{problem.name} has a finite value at {int(finite.sum())} of {number:,} points, too few to describe it"
        )
    if y[finite].min() == y[finite].max():
        raise BenchError(f"{problem.name} has the same value at all {number:,} points, so there is nothing to describe")
    return features(unit[finite], y[finite], seed)


def default_points(dimension: int) -> int:
    """Return the points of a sample in this dimension."""
    return min(max(POINTS * dimension, LEAST_POINTS), MOST_POINTS)


def features(x: Floats, y: Floats, seed: int = 0) -> dict[str, float]:
    """Return the features of the (n, d) points ``x`` of the unit cube and their (n,) finite values ``y``.

    The values are scaled to 0 … 1. ``seed`` chooses where the walk of the information content begins.
    """
    y = y / np.abs(y).max()  # so that no difference overflows
    scaled = (y - y.min()) / (y.max() - y.min())
    distances = cdist(x, x)
    start = int(np.random.default_rng(seed).integers(len(x)))
    with np.errstate(divide="ignore", invalid="ignore"):  # what a degenerate sample does not define is missing
        values_of = (
            distribution(scaled) | meta_models(x, scaled) | dispersion(x, scaled) | nearest_better(distances, scaled)
            | information_content(distances, scaled, start) | {"fitness_distance.correlation": fdc(distances, scaled)}
        )  # fmt: skip
    return {name: float(value) if np.isfinite(value) else np.nan for name, value in values_of.items()}


def distribution(y: Floats) -> dict[str, float]:
    """Return skewness and excess kurtosis with the n - 1 standard deviation, and the peaks of a density of the values.

    A peak holds at least 1% of the values between two minima of a Gaussian kernel density with Scott's bandwidth.
    """
    n = len(y)
    density = gaussian_kde(y)
    reach = 3 * density.factor * y.std(ddof=1)
    at = np.linspace(y.min() - reach, y.max() + reach, 512)
    height = density(at)
    minima = 1 + np.flatnonzero((height[1:-1] < height[:-2]) & (height[1:-1] < height[2:]))
    mass = [part.sum() * (at[1] - at[0]) for part in np.split(height, minima)]
    return {
        "ela_distr.skewness": skew(y) * (1 - 1 / n) ** 1.5,
        "ela_distr.kurtosis": (kurtosis(y) + 3) * (1 - 1 / n) ** 2 - 3,
        "ela_distr.number_of_peaks": sum(share > PEAK for share in mass),
    }


def meta_models(x: Floats, y: Floats) -> dict[str, float]:
    """Return the adjusted R² of four models by least squares, and what the coefficients of two of them show."""
    linear, simple = _fit(x, y)
    squares = np.hstack((x, x**2))
    curved, quadratic = _fit(squares, y)
    slopes, bends = np.abs(linear[1:]), np.abs(curved[1 + x.shape[1] :])
    return {
        "ela_meta.lin_simple.adj_r2": simple,
        "ela_meta.lin_simple.intercept": linear[0],
        "ela_meta.lin_simple.coef.min": slopes.min(),
        "ela_meta.lin_simple.coef.max": slopes.max(),
        "ela_meta.lin_simple.coef.max_by_min": slopes.max() / slopes.min(),
        "ela_meta.lin_w_interact.adj_r2": _interactions(x, y),
        "ela_meta.quad_simple.adj_r2": quadratic,
        "ela_meta.quad_simple.cond": bends.max() / bends.min(),
        "ela_meta.quad_w_interact.adj_r2": _interactions(squares, y),
    }


def dispersion(x: Floats, y: Floats) -> dict[str, float]:
    """Return the mean and median distance among the best points over those among all."""
    whole, ratios = pdist(x), dict[str, float]()
    best = {quantile: pdist(x[y <= np.quantile(y, quantile)]) for quantile in QUANTILES}
    for statistic in (np.mean, np.median):
        among_all = statistic(whole)
        for quantile, among_best in best.items():
            ratio = statistic(among_best) / among_all if len(among_best) else np.nan
            ratios[f"disp.ratio_{statistic.__name__}_{round(100 * quantile):02d}"] = float(ratio)
    return ratios


def nearest_better(distances: Floats, y: Floats) -> dict[str, float]:
    """Return how distances to the nearest and to the nearest better point relate; the best point has the former."""
    between = distances + np.diag(np.full(len(y), np.inf))
    nearest = between.min(axis=1)
    better = np.where(y[np.newaxis] < y[:, np.newaxis], between, np.inf)
    target, reach = better.argmin(axis=1), better.min(axis=1)
    has = np.isfinite(reach)
    popular = np.bincount(target[has], minlength=len(y))
    reach = np.where(has, reach, nearest)
    ratio = nearest / reach
    return {
        "nbc.nn_nb.sd_ratio": nearest.std(ddof=1) / reach.std(ddof=1),
        "nbc.nn_nb.mean_ratio": nearest.mean() / reach.mean(),
        "nbc.nn_nb.cor": _correlation(nearest, reach),
        "nbc.dist_ratio.coeff_var": ratio.std(ddof=1) / ratio.mean(),
        "nbc.nb_fitness.cor": _correlation(popular.astype(float), y),
    }


def information_content(distances: Floats, y: Floats, start: int = 0) -> dict[str, float]:
    """Return the features of the signs of slopes along a walk, over the slope epsilon below which they count as 0."""
    walk = _walk(distances, start)
    slopes = np.diff(y[walk]) / distances[walk[:-1], walk[1:]]
    slopes = np.where(np.isnan(slopes), 0.0, slopes)  # two equal points of equal value
    signs = np.where(np.abs(slopes) < EPSILONS[:, np.newaxis], 0, np.sign(slopes)).astype(np.int8)
    content = np.zeros(len(EPSILONS))
    for one in (-1, 0, 1):
        for other in {-1, 0, 1} - {one}:
            share = ((signs[:, :-1] == one) & (signs[:, 1:] == other)).mean(axis=1)
            content -= np.where(share > 0, share * np.log(np.where(share > 0, share, 1.0)), 0.0) / np.log(6)
    partial = np.array([_changes(row) for row in signs]) / (signs.shape[1] - 1)
    settled, high = EPSILONS[content < SETTLED], EPSILONS[partial > HALF * partial[0]]
    return {
        "ic.h_max": content.max(),
        "ic.eps_s": np.log10(settled.min()) if len(settled) else np.nan,
        "ic.eps_max": np.median(EPSILONS[content == content.max()]),
        "ic.eps_ratio": np.log10(high.max()) if len(high) else np.nan,
        "ic.m0": partial[0],
    }


def fdc(distances: Floats, y: Floats) -> float:
    """Return the correlation of value and distance to the best point of the sample; 1 for a perfect funnel."""
    return _correlation(distances[int(y.argmin())], y)


def feature_ranks(
    table: pd.DataFrame,
    medians: pd.DataFrame,
    blocks: Mapping[str, str] | None = None,
    places: Mapping[str, int] | None = None,
    alpha: float = ALPHA,
) -> pd.DataFrame:
    """Return how each feature goes with the rank of each optimizer over problems, the smallest p first.

    Columns: optimizer, feature, problems, rho (Spearman; positive where the optimizer ranks worse on problems with a
    larger value), p, p_adjusted, for all rows together, and significant (p_adjusted <= ``alpha``). Features that are
    missing or equal on all problems have no row, and neither has an optimizer of one rank; without 10 problems there is
    no row.

    The problems of a block, such as a function in several dimensions, are no independent sample: features and ranks
    are alike in them whether they have to do with each other or not. So the tests exchange the features of whole
    blocks that have problems at the same places, at random, and p is the share of exchanges, the given order included,
    in which rho is as far from its mean, in its standard deviations; of p_adjusted, that in which any is (Westfall and
    Young 1993, Resampling-Based Multiple Testing). Nothing can be significant that is all in one block.

    Args:
        table: features by problem, such as those of :func:`describe`.
        medians: medians by problem and optimizer (:func:`bench.analysis.medians`).
        blocks: the block of each problem; without, each is a block of its own.
        places: where a problem stands in its block, such as its dimension.
        alpha: the level.
    """
    columns = ["optimizer", "feature", "problems", "rho", "p", "p_adjusted"]
    problems = [label for label in medians.index if label in table.index]
    ranks = medians.loc[problems].rank(axis=1)
    ranks = ranks.loc[:, ranks.nunique() > 1]
    given = table.loc[problems]
    given = given.loc[:, (given.nunique() > 1) & (given.notna().sum() >= LEAST_PROBLEMS)]
    if len(problems) < LEAST_PROBLEMS or ranks.empty or given.empty:
        return pd.DataFrame(columns=[*columns, "significant"]).astype({"significant": bool})
    x, y = (_standard_ranks(each.to_numpy(dtype=float)) for each in (given, ranks))
    orders = _exchanges([((blocks or {}).get(label, label), (places or {}).get(label, 0)) for label in problems])
    rho = np.empty((len(orders), x.shape[1], y.shape[1]))
    for start in range(0, len(orders), AT_ONCE):
        rho[start : start + AT_ONCE] = np.einsum("bpf,pk->bfk", x[orders[start : start + AT_ONCE]], y, optimize=True)
    spread = rho.std(axis=0)
    # An exchange that repeats the given order differs from it by rounding alone.
    size = np.round(np.abs(rho - rho.mean(axis=0)) / np.where(spread > 0, spread, np.inf), 9)
    most = size.max(axis=(1, 2))
    feature, optimizer = (part.ravel() for part in np.indices(size.shape[1:]))
    tests = pd.DataFrame(
        {
            "optimizer": ranks.columns[optimizer],
            "feature": given.columns[feature],
            "problems": given.notna().sum().to_numpy()[feature],
            "rho": _rho(given, ranks).ravel(),
            "p": (size >= size[0]).mean(axis=0).ravel(),
            "p_adjusted": (most[:, np.newaxis, np.newaxis] >= size[0]).mean(axis=0).ravel(),
        },
        columns=columns,
    )
    tests["significant"] = (tests["p_adjusted"] <= alpha).astype(bool)
    order = np.lexsort((feature, optimizer, -size[0].ravel(), tests["p"], tests["p_adjusted"]))
    return tests.iloc[order].reset_index(drop=True)


def _rho(features: pd.DataFrame, ranks: pd.DataFrame) -> Floats:
    """Return Spearman's rho of each feature, where it is not missing, and the ranks of each optimizer, (f, k)."""
    rho = np.empty((features.shape[1], ranks.shape[1]))
    for place, feature in enumerate(features):
        known = features[feature].notna()
        x, y = (_standard_ranks(each[known].to_numpy(dtype=float)) for each in (features[[feature]], ranks))
        rho[place] = x[:, 0] @ y
    return rho


def _standard_ranks(values: Floats) -> Floats:
    """Return (n, c) ranks in each column, with mean 0 and squares that add up to 1; 0 where a value is missing."""
    ranks = rankdata(values, axis=0, nan_policy="omit")
    ranks = np.nan_to_num(ranks - np.nanmean(ranks, axis=0))
    return np.asarray(ranks / np.sqrt((ranks**2).sum(axis=0)))


def _exchanges(keys: list[tuple[str, int]]) -> NDArray[np.intp]:
    """Return (EXCHANGES, n) orders of n problems, the given one first, in which blocks with equal places exchange."""
    rows: dict[str, list[tuple[int, int]]] = {}
    for row, (block, place) in enumerate(keys):
        rows.setdefault(block, []).append((place, row))
    alike: dict[tuple[int, ...], list[list[int]]] = {}
    for own in map(sorted, rows.values()):
        alike.setdefault(tuple(place for place, _ in own), []).append([row for _, row in own])
    rng, orders = np.random.default_rng(SEED), np.tile(np.arange(len(keys)), (EXCHANGES, 1))
    for group in map(np.array, alike.values()):  # (blocks, places)
        drawn = rng.permuted(np.tile(np.arange(len(group)), (EXCHANGES - 1, 1)), axis=1)
        orders[1:, group.ravel()] = group[drawn].reshape(EXCHANGES - 1, -1)
    return orders


def _fit(columns: Floats, y: Floats) -> tuple[Floats, float]:
    """Return the coefficients of a linear model, its intercept first, and its adjusted R²; missing without freedom."""
    n, k = columns.shape
    if n <= k + 1:
        return np.full(k + 1, np.nan), np.nan
    design = np.column_stack((np.ones(n), columns))
    coefficients: Floats = np.linalg.lstsq(design, y, rcond=None)[0].astype(np.float64)
    unexplained = ((y - design @ coefficients) ** 2).sum() / ((y - y.mean()) ** 2).sum()
    return coefficients, float(1 - unexplained * (n - 1) / (n - k - 1))


def _interactions(columns: Floats, y: Floats) -> float:
    """Return the adjusted R² with the products of all pairs of columns; missing where there are too many of them."""
    k = columns.shape[1]
    if k * (k + 1) / 2 > MOST_COLUMNS:
        return np.nan
    products = [columns[:, i] * columns[:, j] for i, j in combinations(range(k), 2)]
    return _fit(np.column_stack([columns, *products]), y)[1]


def _walk(distances: Floats, start: int) -> Any:
    """Return the order in which a walk from ``start`` visits all points, each the nearest one not visited."""
    order, left = np.empty(len(distances), dtype=int), np.ones(len(distances), dtype=bool)
    for step in range(len(distances)):
        order[step], left[start] = start, False
        if step + 1 < len(distances):
            start = int(np.where(left, distances[start], np.inf).argmin())
    return order


def _changes(signs: Any) -> int:
    """Return how often the sign changes along a walk, zeros left out."""
    moving = signs[signs != 0]
    return int(np.count_nonzero(np.diff(moving)))


def _correlation(x: Floats, y: Floats) -> float:
    return float(np.corrcoef(x, y)[0, 1])
