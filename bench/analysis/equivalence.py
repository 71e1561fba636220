"""Practical equality: whether optimizers differ by less than a region of practical equivalence (rope).

Across problems, two Bayesian models give the probabilities that the first optimizer is better by more than the rope,
that both are equal within it, and that the second is better (Benavoli, Corani, Demšar and Zaffalon 2017, Journal of
Machine Learning Research 18), for a pair's differences of medians in units of the rope:

- the signed-rank test: a Dirichlet process over the differences (Benavoli, Mangili, Corani, Zaffalon and Ruggeri 2014,
  ICML), which compares sums of two differences with twice the rope, as Wilcoxon's test does;
- a hierarchical model, which weighs each problem by the error of its difference: difference ~ N(true difference,
  error²), true difference ~ N(mean, spread²) (Gelman et al. 2013, Bayesian Data Analysis, section 5.4). Corani,
  Benavoli, Demšar, Mangili and Zaffalon (2017, Machine Learning 106) use Student's t for the second line and correlated
  cross-validation for the first; trials here are independent. The probabilities are those of a further problem.

Problem by problem, two optimizers are equivalent where the interval of their difference of medians lies within the
rope: two one-sided tests (Schuirmann 1987, Journal of Pharmacokinetics and Biopharmaceutics 15), by a percentile
bootstrap.
"""

from __future__ import annotations

from itertools import combinations
from math import comb
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import norm

from bench.analysis.cells import cells, labels, quantiles
from bench.analysis.direction import ALPHA
from bench.analysis.pairwise import percentile_interval
from bench.study.rope import Rope
from bench.typing import Floats

DRAWS = 20_000  # from a posterior
RESAMPLES = 1_999
BATCH = 2_000  # draws at a time, to bound memory
PRIOR = 0.5  # weight of the prior observation of no difference (Benavoli et al. 2017)
FEWEST = 6  # trials of a cell whose bootstrap interval of the median is used
FAR = 1e6  # ropes: a difference that is infinite, or where the rope has no width
PAIR = ("problem", "first", "second", "difference", "error", "low", "high", "rope", "wide", "equivalent")


def differences(frame: pd.DataFrame, rope: Rope | float | str, alpha: float = ALPHA, seed: int = 0) -> pd.DataFrame:
    """Return one row a problem and pair of optimizers that both have trials there.

    Columns: problem, first, second; ``difference`` of the medians, the first less the second; its bootstrap standard
    ``error`` and the interval low to high of level 1 - 2 alpha / pairs (Bonferroni over the pairs of a problem); the
    half width ``rope`` in the unit of the problem; ``wide``, whether it spans all finite values on the problem; and
    ``equivalent``, whether the interval lies within the rope. Interval and error are missing below six trials.

    A percentage counts of the smaller size of the two medians, also within a resample. Failed trials are +inf,
    near-ties are ties; two infinite medians do not differ.
    """
    rope = Rope.read(rope, "the rope")
    by_cell, optimizers = cells(frame, merge=True), labels(frame, "optimizer")
    level = 1 - 2 * alpha / max(comb(len(optimizers), 2), 1)
    rows: list[tuple[Any, ...]] = []
    for problem in labels(frame, "problem"):
        samples = {label: by_cell[problem, label] for label in optimizers if len(by_cell[problem, label])}
        finite = [values[np.isfinite(values)] for values in samples.values()]
        reach = float(np.ptp(np.concatenate(finite))) if sum(map(len, finite)) else 0.0
        rng = np.random.default_rng(seed)
        resampled = {label: _medians(values, rng) for label, values in samples.items() if len(values) >= FEWEST}
        medians = {label: np.array([quantiles(values, 0.5)]) for label, values in samples.items()}
        for first, second in combinations(samples, 2):
            here = medians[first], medians[second]
            width = float(rope.widths(*here)[0])
            inference = np.nan, np.nan, np.nan, False
            if first in resampled and second in resampled:
                inference = _inference(resampled[first], resampled[second], rope, level)
            *interval, equivalent = inference
            wide = bool(0 < reach <= width)
            rows.append((problem, first, second, float(_less(*here)[0]), *interval, width, wide, equivalent))
    return pd.DataFrame(rows, columns=list(PAIR)).astype({"wide": bool, "equivalent": bool})


def probabilities(table: pd.DataFrame, seed: int = 0) -> pd.DataFrame:
    """Return one row a pair of optimizers: first, second, problems, and the probabilities of both models.

    Columns ``first_better``, ``equal`` and ``second_better`` are of the signed-rank test; ``first_better_h``,
    ``equal_h`` and ``second_better_h`` of the hierarchical model, missing below three problems with a finite error.
    Lower values are better.

    Args:
        table: as :func:`differences` returns it.
        seed: repeats the draws.
    """
    rows = []
    for (first, second), of_pair in table.groupby(["first", "second"], sort=False):
        difference, error, rope = of_pair[["difference", "error", "rope"]].to_numpy(dtype=float).T
        z, errors = in_ropes(difference, rope), error / np.where(rope > 0, rope, np.nan)
        usable = np.isfinite(errors) & (np.abs(z) < FAR)
        further = hierarchical(z[usable], errors[usable], seed) if usable.sum() > 2 else (np.nan,) * 3
        rows.append((first, second, len(of_pair), *signed_rank(z, seed), *further))
    names = ["first_better", "equal", "second_better"]
    return pd.DataFrame(rows, columns=["first", "second", "problems", *names, *(f"{name}_h" for name in names)])


def in_ropes(difference: Floats, rope: Floats) -> Floats:
    """Return differences in units of the rope, at most ±1e6."""
    scaled = np.where(rope > 0, difference / np.where(rope > 0, rope, 1.0), np.sign(difference) * FAR)
    return np.asarray(np.clip(scaled, -FAR, FAR))


def signed_rank(z: Floats, seed: int = 0) -> tuple[float, float, float]:
    """Return the probabilities that values below -1, within ±1 and above 1 prevail, by the Bayesian signed-rank test.

    ``z`` are (n,) differences in units of the rope, first less second: a low one means that the first is better. In
    each draw of weights from the posterior one of the three has most of the pairs; the probabilities are its shares of
    the draws.
    """
    all_z = np.append(0.0, z)
    sums = all_z[:, np.newaxis] + all_z
    below, above = (np.greater(side * sums, 2.0) + 0.5 * np.equal(side * sums, 2.0) for side in (-1.0, 1.0))
    rng, counts = np.random.default_rng(seed), np.zeros(3)
    for _ in range(DRAWS // BATCH):
        weights = rng.dirichlet(np.append(PRIOR, np.ones(len(z))), BATCH)
        left, right = (((weights @ side) * weights).sum(axis=1) for side in (below, above))
        counts += np.bincount(np.argmax([left, 1 - left - right, right], axis=0), minlength=3)
    return tuple(float(chance) for chance in counts / counts.sum())  # type: ignore[return-value]


def hierarchical(z: Floats, errors: Floats, seed: int = 0) -> tuple[float, float, float]:
    """Return the probabilities that true differences below -1, within ±1 and above 1 prevail, by the hierarchy.

    ``z`` are (n,) differences in units of the rope, ``errors`` their standard errors. Priors are flat in the mean and
    in the spread of the true differences. The posterior of the spread is computed on a grid, and the mean given it is
    normal, so that draws are exact. As in :func:`signed_rank`, the probabilities are the shares of the draws in which
    one of the three has most of the distribution of true differences.
    """
    errors = np.maximum(errors, 1e-3)  # a difference without any error among resamples is not certain
    spreads = np.concatenate(([0.0], np.geomspace(1e-3, 10, 400))) * max(
        float(np.std(z)), float(np.median(errors)), 1e-3
    )
    variances = errors**2 + spreads[:, np.newaxis] ** 2
    precision = (1 / variances).sum(axis=1)
    mean = (z / variances).sum(axis=1) / precision
    log_density = -0.5 * (
        np.log(precision) + (np.log(variances) + (z - mean[:, np.newaxis]) ** 2 / variances).sum(axis=1)
    )
    mass = np.exp(log_density - log_density.max()) * np.gradient(spreads)
    rng = np.random.default_rng(seed)
    drawn = rng.choice(len(spreads), DRAWS, p=mass / mass.sum())
    centre = mean[drawn] + rng.standard_normal(DRAWS) / np.sqrt(precision[drawn])
    spread = np.maximum(spreads[drawn], 1e-12)
    left, right = norm.cdf((-1 - centre) / spread), norm.sf((1 - centre) / spread)
    winners = np.argmax([left, 1 - left - right, right], axis=0)
    return tuple(float(chance) for chance in np.bincount(winners, minlength=3) / DRAWS)  # type: ignore[return-value]


def _inference(first: Floats, second: Floats, rope: Rope, level: float) -> tuple[float, float, float, bool]:
    """Return error and interval of the difference of resampled medians, and whether the interval is in the rope."""
    moved, widths = _less(first, second), rope.widths(first, second)
    low, high = percentile_interval(moved, level)
    error = float(np.std(moved, ddof=1)) if np.isfinite(moved).all() else np.inf
    least, most = percentile_interval(in_ropes(moved, widths), level)
    return error, low, high, bool(least >= -1 and most <= 1)


def _medians(values: Floats, rng: np.random.Generator) -> Floats:
    """Return the medians of bootstrap resamples."""
    drawn = rng.choice(values, (RESAMPLES, len(values)))
    return np.asarray(np.quantile(drawn, 0.5, axis=1, method="linear" if np.isfinite(values).all() else "higher"))


def _less(first: Floats, second: Floats) -> Floats:
    """Return first less second; two infinite values do not differ."""
    with np.errstate(invalid="ignore"):
        return np.where(np.isinf(first) & np.isinf(second), 0.0, first - second)
