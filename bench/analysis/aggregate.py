"""Effect sizes over all problems, with intervals from a stratified bootstrap (Agarwal et al. 2021).

Trials are resampled within each problem and optimizer, 9,999 times: the intervals show how far other trials on the
same problems could move a value, not what other problems would show. Only problems on which every optimizer has a
trial count. An interval is missing where a cell has one trial, which leaves nothing to resample.
Source: Agarwal, Schwarzer, Castro, Courville and Bellemare, Deep reinforcement learning at the edge of the
statistical precipice, NeurIPS 2021.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import bootstrap, trim_mean

from bench.analysis.cells import cells, labels, merge_near_ties, reference_values, scores
from bench.analysis.pairwise import RESAMPLES, a12, a12_replicates, percentile_interval
from bench.problem import Floats

TRIMMED = 0.25  # from either end: what is left is the interquartile mean
BATCH = 1_000  # resamples at a time, to bound memory


def probability_of_improvement(frame: pd.DataFrame, seed: int = 0) -> pd.DataFrame:
    """Return the probability that ``first`` ends below ``second``: first, second, problems, probability, low and high.

    The probability is the mean over problems of A12, with its 95 % percentile bootstrap interval; missing where no
    problem has trials of every optimizer.
    """
    found, problems, optimizers = cells(frame, merge=True), _complete(frame), labels(frame, "optimizer")
    pairs = list(combinations(optimizers, 2))
    chances, replicates = np.zeros((len(pairs), len(problems))), np.zeros((len(pairs), RESAMPLES))
    for i, problem in enumerate(problems):
        for j, (first, second) in enumerate(pairs):
            this, other = found[problem, first], found[problem, second]
            chances[j, i] = a12(this, other)
            # a seed for each problem: resampled alike, problems would vary together
            replicates[j] += a12_replicates(this, other, seed=(seed, i)) / len(problems)
    fewest = {each: min((len(found[problem, each]) for problem in problems), default=0) for each in optimizers}
    rows = []
    for (first, second), chance, own in zip(pairs, chances, replicates, strict=True):
        low, high = percentile_interval(own) if min(fewest[first], fewest[second]) > 1 else (np.nan, np.nan)
        rows.append((first, second, len(problems), chance.mean() if problems else np.nan, low, high))
    return pd.DataFrame(rows, columns=["first", "second", "problems", "probability", "low", "high"])


def normalised_errors(frame: pd.DataFrame, optima: Mapping[str, float] | None = None) -> pd.DataFrame:
    """Return the error of each trial on a scale that all problems share: problem, optimizer, trial and error.

    0 is the reference value of the problem: its optimum, or the lowest score of all trials where the optimum is unknown
    or beaten (:func:`bench.analysis.reference_values`). 1 is the median error of all trials of all optimizers on the
    problem, or the largest finite error where that median is 0 or infinite. A failed trial has +inf; near-ties are
    ties. The scale depends on the optimizers compared.

    Args:
        frame: the tidy frame.
        optima: the best known objective value, by problem, where one is known.
    """
    by_problem = scores(frame).groupby(frame["problem"].astype(object))
    zero = reference_values({str(problem): least for problem, least in by_problem.min().items()}, optima)
    errors = by_problem.transform(lambda own: _normalised(own.to_numpy(), zero[str(own.name)].value))
    return frame[["problem", "optimizer", "trial"]].assign(error=errors)


def interquartile_mean(frame: pd.DataFrame, optima: Mapping[str, float] | None = None, seed: int = 0) -> pd.DataFrame:
    """Return one row an optimizer: problems, n (trials), and the interquartile mean of its normalised errors.

    ``iqm`` is the mean of the middle half of the :func:`normalised_errors` of all trials on all problems, low to
    high its 95 % percentile bootstrap interval. It is +inf once more than a quarter of the trials failed, and missing
    without any problem that has trials of every optimizer. The scale of the errors is not resampled.
    """
    problems = _complete(frame)
    errors = normalised_errors(frame[frame["problem"].isin(problems)], optima)
    rows = []
    for optimizer in labels(frame, "optimizer"):
        own = errors[errors["optimizer"] == optimizer]
        strata = [group.to_numpy() for _, group in own.groupby("problem", sort=False, observed=True)["error"]]
        iqm = float(trim_mean(own["error"], TRIMMED)) if strata else np.nan
        low, high = _interval(strata, seed) if strata and min(map(len, strata)) > 1 else (np.nan, np.nan)
        rows.append((optimizer, len(problems), len(own), iqm, low, high))
    return pd.DataFrame(rows, columns=["optimizer", "problems", "n", "iqm", "low", "high"])


def _complete(frame: pd.DataFrame) -> list[str]:
    """Return the problems on which every optimizer has a trial."""
    found, optimizers = cells(frame), labels(frame, "optimizer")
    return [problem for problem in labels(frame, "problem") if all(len(found[problem, each]) for each in optimizers)]


def _normalised(values: Floats, reference: float) -> Floats:
    """Return the scores of one problem as errors, 0 at the reference and 1 at their median."""
    merged = merge_near_ties(np.append(values, reference))
    errors, finite = merged[:-1], np.isfinite(merged[:-1])
    errors[finite] -= merged[-1]
    middle, largest = float(np.median(errors)), float(errors[finite].max(initial=0.0))
    return np.asarray(errors / (middle if 0 < middle < np.inf else largest if largest > 0 else 1.0))


def _interval(strata: list[Floats], seed: int) -> tuple[float, float]:
    """Return the 95 % interval of the interquartile mean of samples that are resampled separately."""

    def iqm(*samples: Floats, axis: int) -> Any:
        return trim_mean(np.concatenate(samples, axis=axis), TRIMMED, axis=axis)

    with np.errstate(invalid="ignore"):  # the library's own interval and error, both unused, fail on infinite errors
        resampled = bootstrap(
            strata,
            iqm,
            n_resamples=RESAMPLES,
            batch=BATCH,
            vectorized=True,
            method="percentile",
            random_state=np.random.default_rng(seed),
        )
    return percentile_interval(resampled.bootstrap_distribution)
