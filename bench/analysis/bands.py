"""Bands of runtime distributions over the budget, and when one optimizer is shown to be ahead of another.

Problems and targets are given, runs are the sample: another study would have other runs of the same optimizers on the
same problems. The curve of an optimizer is the mean over problems of the mean over runs of the share of targets that a
run has reached (:func:`bench.analysis.ecdf`), so its variance is that of runs within problems. What runs did not show
may happen all the same: the variance counts one and a half runs that reach everything at once, and as many that reach
nothing.

Bands hold for all budgets together, at 95%: their width is that of the largest standardised deviation of the curve
with normal multipliers of the runs (Chernozhukov, Chetverikov and Kato 2013, Annals of Statistics 41), widened to
Student's t with Satterthwaite's degrees of freedom (1946, Biometrics Bulletin 2). The band of a curve reaches as far as
the interval of this width or Wilson's (1927) of as many runs as have this variance, which are at least the runs made.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import norm, t

from bench.analysis.anytime import Counts
from bench.analysis.cells import labels
from bench.contract.typing import Floats

UNSEEN = 1.5  # runs that reach everything at once, and as many that reach nothing, beside those of a cell
MULTIPLIERS = 1000
LEVEL = 0.95
LEADS_LEVEL = 0.975  # for 95%: near its ends a curve is skewed, and of 51 runs up to 8% of studies had a wrong lead


class Curve(NamedTuple):
    """The curve of an optimizer over the grid, with what its band is made of.

    Attributes:
        fraction: the share of targets reached, (G,).
        variance: of it, (G,).
        freedom: the degrees of freedom of this variance, (G,).
        process: deviations of the curve with normal multipliers of its runs, (MULTIPLIERS, G).
        runs: as many as their means over problems are worth: their number where all cells have as many.
    """

    fraction: Floats
    variance: Floats
    freedom: Floats
    process: Floats
    runs: float


def curve_bands(hits: pd.DataFrame, grid: Counts, dimensions: Mapping[str, int] | None = None) -> pd.DataFrame:
    """Return the curve of each optimizer with its band: optimizer, evaluations, fraction, low and high.

    With ``dimensions``, the d of each problem, the unit is an evaluation a dimension and its column ``per_dimension``.
    An optimizer with a single run on any problem has no band.

    Args:
        hits: of :func:`bench.analysis.hitting_times`.
        grid: increasing numbers of evaluations, or of evaluations a dimension.
        dimensions: of the problems, by label.
    """
    unit = "evaluations" if dimensions is None else "per_dimension"
    tables = []
    for optimizer, curve in _curves(hits, grid, dimensions).items():
        width = _width((np.abs(curve.process) / np.sqrt(curve.variance)).max(axis=1), curve.freedom)
        spread = curve.fraction * (1 - curve.fraction)
        ratio = width**2 / np.maximum(curve.runs, spread / curve.variance)
        middle = (curve.fraction + ratio / 2) / (1 + ratio)
        half = np.sqrt(ratio * (spread + ratio / 4)) / (1 + ratio)
        equal = width * np.sqrt(curve.variance)
        low, high = np.minimum(middle - half, curve.fraction - equal), np.maximum(middle + half, curve.fraction + equal)
        ends = {"low": np.clip(low, 0, 1), "high": np.clip(high, 0, 1)}
        tables.append(pd.DataFrame({"optimizer": optimizer, unit: grid, "fraction": curve.fraction} | ends))
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=["optimizer", unit, "fraction"])


def leads(
    hits: pd.DataFrame | Iterable[pd.DataFrame],
    grid: Counts,
    dimensions: Mapping[str, int] | None = None,
    pairs: Sequence[tuple[str, str]] | None = None,
) -> pd.DataFrame:
    """Return the ranges in which pairs of curves part: first, second, evaluations, difference, low, high and ahead.

    The bands of the differences hold for all budgets and all pairs of optimizers together, so that pairs may be chosen
    after the results were seen. ``ahead`` is the optimizer that has
    reached more targets by then, as far as the band shows it, else "". Compare optimizers on the same problems only.

    Args:
        hits: of :func:`bench.analysis.hitting_times`; or some optimizers after the others, as all may fill the memory.
        grid: increasing numbers of evaluations, or of evaluations a dimension.
        dimensions: as for ``curve_bands``.
        pairs: of optimizers to show; all by default.
    """
    unit = "evaluations" if dimensions is None else "per_dimension"
    curves = _curves(hits, grid, dimensions)
    columns = ["first", "second", unit, "difference", "low", "high", "ahead"]
    every = list(combinations(curves, 2))
    if not every:
        return pd.DataFrame(columns=columns)
    largest = np.zeros(MULTIPLIERS)
    for one, other in ((curves[first], curves[second]) for first, second in every):
        deviation = np.abs(one.process - other.process) / np.sqrt(one.variance + other.variance)
        largest = np.fmax(largest, deviation.max(axis=1))  # an optimizer without a band has no say
    tables = []
    for first, second in every if pairs is None else pairs:
        one, other = curves[first], curves[second]
        variance = one.variance + other.variance
        freedom = variance**2 / (one.variance**2 / one.freedom + other.variance**2 / other.freedom)
        half = _width(largest, freedom, LEADS_LEVEL) * np.sqrt(variance)
        difference = one.fraction - other.fraction
        low, high = difference - half, difference + half
        ahead = np.where(low > 0, first, np.where(high < 0, second, ""))
        values = (first, second, grid, difference, low, high, ahead)
        tables.append(pd.DataFrame(dict(zip(columns, values, strict=True))))
    return pd.concat(tables, ignore_index=True)


def spells(differences: pd.DataFrame) -> pd.DataFrame:
    """Return the budgets over which one optimizer is shown to be ahead: first, second, ahead, begin and end.

    ``differences`` are those of :func:`leads`. A pair of which both are ahead somewhere has crossed.
    """
    unit = differences.columns[2]
    rows = []
    for (first, second), pair in differences.groupby(["first", "second"], sort=False):
        run = (pair["ahead"] != pair["ahead"].shift()).cumsum()
        for _, spell in pair.groupby(run, sort=False):
            if leader := spell["ahead"].iloc[0]:
                rows.append((first, second, leader, spell[unit].iloc[0], spell[unit].iloc[-1]))
    return pd.DataFrame(rows, columns=["first", "second", "ahead", "begin", "end"])


def _width(largest: Floats, freedom: Floats, level: float = LEVEL) -> Floats:
    """Return how many standard errors a band reaches, (G,), from the largest deviations, (MULTIPLIERS,)."""
    width = max(float(np.quantile(largest, level)), float(norm.isf((1 - level) / 2)))
    return np.asarray(t.isf(norm.sf(width), freedom))


def _curves(
    hits: pd.DataFrame | Iterable[pd.DataFrame], grid: Counts, dimensions: Mapping[str, int] | None
) -> dict[str, Curve]:
    """Return the curve of each optimizer that has runs."""
    rng = np.random.default_rng(0)
    curves: dict[str, Curve] = {}
    for part in [hits] if isinstance(hits, pd.DataFrame) else hits:
        if dimensions is not None:
            part = part.assign(evaluations=part["evaluations"] / part["problem"].astype(object).map(dimensions))
        groups = part.groupby("optimizer", observed=True).indices
        for optimizer in (label for label in labels(part, "optimizer") if label in groups):
            curves[optimizer] = curve_of(_run_shares(part.iloc[groups[optimizer]], grid), rng)
    return curves


def _run_shares(rows: pd.DataFrame, grid: Counts) -> list[Floats]:
    """Return the share of its targets that each run of each cell has reached, (runs, G)."""
    run = rows.groupby(["problem", "trial"], sort=False, observed=True).ngroup().to_numpy()
    place = np.searchsorted(grid, rows["evaluations"].to_numpy(dtype=float))  # the first count by which it is reached
    size = len(grid) + 1
    counts = np.bincount(run * size + place, minlength=(run.max(initial=-1) + 1) * size).reshape(-1, size)
    shares = np.cumsum(counts[:, :-1], axis=1) / counts.sum(axis=1, keepdims=True)
    problem = pd.factorize(rows["problem"])[0][np.unique(run, return_index=True)[1]]
    return [shares[problem == cell] for cell in range(problem.max(initial=-1) + 1)]


def curve_of(cells: Sequence[Floats], rng: np.random.Generator) -> Curve:
    """Return the mean over cells of the mean over runs, whatever their numbers, and what its band is made of."""
    sizes = np.array([len(cell) for cell in cells])
    weight, shape = 1 / len(cells), cells[0].shape[1]
    fraction, process = np.zeros(shape), np.zeros((MULTIPLIERS, shape))
    parts = np.empty((len(cells), shape))
    for place, (runs, cell) in enumerate(zip(sizes, cells, strict=True)):
        mean = cell.mean(axis=0)
        fraction += weight * mean
        every = runs + 2 * UNSEEN
        centre = (cell.sum(axis=0) + UNSEEN) / every
        squares = ((cell - centre) ** 2).sum(axis=0) + UNSEEN * (centre**2 + (1 - centre) ** 2)
        parts[place] = weight**2 * squares / (every - 1) / runs if runs > 1 else np.nan
        multipliers = rng.standard_normal((MULTIPLIERS, runs)) * np.sqrt(runs / max(runs - 1, 1))
        process += weight / runs * multipliers @ (cell - mean)
    variance = parts.sum(axis=0)
    freedom = variance**2 / (parts**2 / np.maximum(sizes - 1, 1)[:, np.newaxis]).sum(axis=0)
    return Curve(fraction, variance, freedom, process, 1 / (weight**2 * float((1 / sizes).sum())))
