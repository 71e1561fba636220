"""Tests and effect sizes across problems; pooling the trials of all problems would count one problem many times over.

The tests start from :func:`bench.analysis.medians`, problems by optimizers, so that each problem counts once, and
follow Demšar (2006, Journal of Machine Learning Research 7). Lower is better; +inf, where half of the trials failed,
ranks last and ties with itself.

The effect sizes have intervals from a stratified bootstrap (Agarwal, Schwarzer, Castro, Courville and Bellemare, Deep
reinforcement learning at the edge of the statistical precipice, NeurIPS 2021): trials are resampled within each problem
and optimizer, 9,999 times, so the intervals show how far other trials on the same problems could move a value, not what
other problems would show. Only problems on which every optimizer has a trial count. An interval is missing where a cell
has one trial, which leaves nothing to resample.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from itertools import combinations
from math import factorial, inf, sqrt
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import bootstrap, f, friedmanchisquare, rankdata, studentized_range, trim_mean

from bench.analysis.cells import NEAR, cells, complete_problems, labels, merge_near_ties, reference_values, scores
from bench.analysis.pairwise import (
    ALPHA,
    RESAMPLES,
    a12,
    a12_replicates,
    alike,
    delong,
    holm,
    logit_intervals,
    percentile_interval,
    resampled,
)
from bench.problem import Floats

TRIMMED = 0.25  # from either end: the mean of the rest is the interquartile mean
BATCH = 1_000  # resamples at a time, to bound memory
FEWER = 999  # resamples of each of more than 32 optimizers


def average_ranks(medians: pd.DataFrame) -> pd.Series[float]:
    """Return the average rank of each optimizer over the problems, 1 for the lowest; ties share their mean rank."""
    return medians.rank(axis=1).mean()


def friedman(medians: pd.DataFrame) -> pd.DataFrame:
    """Test whether any optimizer ranks differently from the others over all problems, in one row.

    Columns: problems, optimizers; ``statistic``, Friedman's chi-squared corrected for ties (Friedman 1937), and its
    p; ``iman_davenport``, the less conservative F of Iman and Davenport (1980, Communications in Statistics A9), its
    degrees of freedom df1 and df2, and p_iman_davenport; ``note``.

    The note is "too few optimizers" below three, "too few problems" below two, or "identical" where no problem ranks
    any two optimizers differently; the statistics are then missing and p = 1. Where all problems rank the optimizers
    alike F is infinite. Its p is never below k!^(1 - n), the chance of that agreement between n untied rankings.
    """
    n, k = medians.shape
    ranks = medians.rank(axis=1)
    note = ""
    if k < 3:
        note = "too few optimizers"
    elif n < 2:
        note = "too few problems"
    elif ranks.eq(ranks.iloc[:, 0], axis=0).all(axis=None):
        note = "identical"
    row: dict[str, Any] = {"problems": n, "optimizers": k, "statistic": np.nan, "p": 1.0}
    row |= {"iman_davenport": np.nan, "df1": k - 1, "df2": (k - 1) * max(n - 1, 0), "p_iman_davenport": 1.0}
    if not note:
        test = friedmanchisquare(*ranks.to_numpy().T)
        chi2, largest = float(test.statistic), n * (k - 1)
        ratio = inf if np.isclose(chi2, largest, rtol=1e-9) else (n - 1) * chi2 / (largest - chi2)
        row |= {"statistic": chi2, "p": float(test.pvalue)}
        # F only approximates: no p can be below the chance that all problems rank the optimizers alike
        p_f = max(float(f.sf(ratio, row["df1"], row["df2"])), 1 / factorial(k) ** (n - 1))
        row |= {"iman_davenport": ratio, "p_iman_davenport": p_f}
    return pd.DataFrame([row | {"note": note}])


def relative_medians(medians: pd.DataFrame, optima: Mapping[str, float] | None = None) -> tuple[pd.DataFrame, str]:
    """Return the medians on a scale on which problems can be compared, and the name of that scale.

    A signed-rank test ranks differences across problems, so an error ten times as large must mean the same on each.
    One scale holds for all problems, the first that all of them allow:

    - "log10 error": log10(median - optimum), where every problem's optimum is known and lies below every median by
      more than rounding;
    - "log10 median": where all medians are positive;
    - "share of range": (median - lowest) / (highest - lowest) over the finite medians of a problem.
    """
    if optima is not None and all(problem in optima for problem in medians.index):
        optimum = pd.Series({problem: optima[problem] for problem in medians.index}, dtype=float)
        error = medians.sub(optimum, axis=0)
        if error.gt(NEAR * optimum.abs(), axis=0).all(axis=None):
            return error.apply(np.log10), "log10 error"
    if (medians > 0).all(axis=None):
        return medians.apply(np.log10), "log10 median"
    finite = medians.where(np.isfinite(medians))
    lowest, spread = finite.min(axis=1), finite.max(axis=1) - finite.min(axis=1)
    share = finite.sub(lowest, axis=0).div(spread.where(spread > 0, 1.0), axis=0)
    return share.fillna(inf), "share of range"


def wilcoxon_tests(
    medians: pd.DataFrame, optima: Mapping[str, float] | None = None, alpha: float = ALPHA
) -> pd.DataFrame:
    """Return Wilcoxon's signed-rank test of each pair of optimizers: is one lower on most problems?

    Columns: first, second, problems; ``statistic``, the smaller sum of ranks, and its exact two-sided p; p_holm,
    adjusted over all pairs (Holm 1979); significant (p_holm <= alpha); ``lower``, the optimizer with the larger sum
    of ranks in its favour ("" where they are equal); ``scale``, what is compared (:func:`relative_medians`);
    ``note``, which is "identical" where no problem differs and "untestable" where too few differ for any p <= alpha.
    Both have p = 1.

    The ranks of problems without a difference are split between both sums (Demšar 2006, section 3.1.3), and so are
    those of problems that both optimizers failed. p is exact also with ties: the share of all ways to sign the ranks
    that leave the sums as far apart.
    """
    relative, scale = relative_medians(medians, optima)
    rows: list[dict[str, Any]] = []
    values = {optimizer: relative[optimizer].to_numpy(dtype=float) for optimizer in medians.columns}
    for first, second in combinations(medians.columns, 2):
        with np.errstate(invalid="ignore"):
            difference = np.nan_to_num(values[first] - values[second], posinf=inf, neginf=-inf)  # inf - inf: none
        rows.append({"first": first, "second": second, "problems": len(medians), **signed_ranks(difference, alpha)})
    columns = ["first", "second", "problems", "statistic", "p", "p_holm", "significant", "lower", "scale", "note"]
    tests = pd.DataFrame(rows, columns=columns)
    tests["p_holm"] = holm(tests["p"].to_numpy(dtype=float))
    favoured = tests["first"].where(tests["lower"] < 0, tests["second"].where(tests["lower"] > 0, ""))
    return tests.assign(significant=(tests["p_holm"] <= alpha).astype(bool), lower=favoured, scale=scale)


def nemenyi(medians: pd.DataFrame) -> pd.DataFrame:
    """Return first, second and p of Nemenyi's test for each pair (Nemenyi 1963), from the difference of average ranks.

    A companion to the critical-difference diagram; it is more conservative than :func:`wilcoxon_tests`, and its p
    depends on the other optimizers. p = 1 without any problem.
    """
    from scikit_posthocs import posthoc_nemenyi_friedman  # slow: it imports the drawing libraries

    pairs = list(combinations(range(medians.shape[1]), 2))
    ranks = medians.rank(axis=1).to_numpy()
    p = posthoc_nemenyi_friedman(ranks).to_numpy() if len(ranks) and pairs else np.ones((len(pairs) + 1,) * 2)
    rows = [(medians.columns[i], medians.columns[j], p[i, j]) for i, j in pairs]
    return pd.DataFrame(rows, columns=["first", "second", "p"])


@lru_cache
def critical_difference(k: int, n: int, alpha: float = ALPHA) -> float:
    """Return the critical difference of the average ranks of k optimizers on n problems (Demšar 2006).

    q_alpha sqrt(k (k + 1) / (6 n)), with q_alpha the quantile of the studentised range over sqrt(2).
    """
    q = studentized_range.ppf(1 - alpha, k, inf) / sqrt(2)
    return float(q * sqrt(k * (k + 1) / (6 * n)))


def cliques(average_ranks: pd.Series[float], difference: float) -> list[tuple[str, ...]]:
    """Return the groups of at least two optimizers whose average ranks lie closer than the critical difference.

    Only the largest groups are returned, each from its lowest rank on: the bars of a critical-difference diagram.
    """
    ordered = average_ranks.sort_values(kind="stable")
    groups: list[tuple[str, ...]] = []
    last = 0
    for start, rank in enumerate(ordered):
        end = int((ordered < rank + difference).sum())
        if end > max(last, start + 1):
            groups.append(tuple(ordered.index[start:end]))
            last = end
    return groups


def wilcoxon_cliques(average_ranks: pd.Series[float], tests: pd.DataFrame) -> list[tuple[str, ...]]:
    """Return the groups of at least two optimizers, neighbours by average rank, of which no pair differs significantly.

    ``tests`` are those of :func:`wilcoxon_tests`. They depend on the two optimizers alone, unlike differences of
    average ranks (Benavoli, Corani and Mangili 2016, Journal of Machine Learning Research 17). Only the largest groups
    are returned: the bars of a critical-difference diagram.
    """
    ordered = [str(label) for label in average_ranks.dropna().sort_values(kind="stable").index]
    first, second, clear = (tests[name] for name in ("first", "second", "significant"))
    apart = {frozenset(pair) for *pair, differs in zip(first, second, clear, strict=True) if differs}
    groups: list[tuple[str, ...]] = []
    last = 0
    for start in range(len(ordered)):
        end = start + 1
        while end < len(ordered) and not any(frozenset((each, ordered[end])) in apart for each in ordered[start:end]):
            end += 1
        if end > max(last, start + 1):
            groups.append(tuple(ordered[start:end]))
            last = end
    return groups


def probability_of_improvement(frame: pd.DataFrame, seed: int = 0) -> pd.DataFrame:
    """Return the probability that ``first`` ends below ``second``: first, second, problems, probability, low and high.

    The probability is the mean over problems of A12, with its 95 % interval: the percentile bootstrap, or from 33
    optimizers on that of its variance (:func:`bench.analysis.pairwise.delong`). The mean is missing where no problem
    has trials of every optimizer, the interval where a cell of either has a single trial.
    """
    found, problems, optimizers = cells(frame, merge=True), complete_problems(frame), labels(frame, "optimizer")
    samples = [[found[problem, each] for each in optimizers] for problem in problems]
    first, second = np.triu_indices(len(optimizers), 1)
    sizes = np.array([[len(own) for own in each] for each in samples], dtype=int)
    sizes = sizes.reshape(len(problems), len(optimizers))
    fewest = sizes.min(axis=0, initial=len(frame))
    known = bool(problems) & (np.minimum(fewest[first], fewest[second]) > 1)
    chance, low, high = (np.full(len(first), np.nan) for _ in range(3))
    if problems and resampled(len(optimizers)):
        chances, replicates = np.zeros((len(first), len(problems))), np.zeros((len(first), RESAMPLES))
        for i, own in enumerate(samples):
            for pair, (this, other) in enumerate(combinations(own, 2)):
                chances[pair, i] = a12(this, other)
                # a seed for each problem: resampled alike, problems would vary together
                replicates[pair] += a12_replicates(this, other, seed=(seed, i)) / len(problems)
        chance = chances.mean(axis=1)
        for pair in np.flatnonzero(known).tolist():
            low[pair], high[pair] = percentile_interval(replicates[pair])
    elif problems:
        chance, variance = np.zeros((2, len(first)))
        for own in samples:
            for pairs, these, others in alike(own):
                chances, variances = delong(these, others)
                chance[pairs] += chances / len(problems)
                variance[pairs] += variances / len(problems) ** 2
        low[known], high[known] = logit_intervals(chance[known], variance[known])
    names = np.array(optimizers, dtype=object)
    return pd.DataFrame(
        {"first": names[first], "second": names[second], "problems": len(problems), "probability": chance}
        | {"low": low, "high": high}
    )


def normalised_errors(frame: pd.DataFrame, optima: Mapping[str, float] | None = None) -> pd.DataFrame:
    """Return the error of each trial on a scale that all problems share: problem, optimizer, trial and error.

    0 is the reference value of the problem: its optimum, or the lowest score of all trials where the optimum is unknown
    or beaten (:func:`bench.analysis.reference_values`). 1 is the median error of all trials of all optimizers on the
    problem, or the largest finite error where that median is 0 or infinite. A failed trial has +inf; near-ties are
    ties. The scale depends on the optimizers compared.
    """
    by_problem = scores(frame).groupby(frame["problem"].astype(object))
    zero = reference_values({str(problem): least for problem, least in by_problem.min().items()}, optima)
    errors = by_problem.transform(lambda own: _normalised(own.to_numpy(), zero[str(own.name)].value))
    return frame[["problem", "optimizer", "trial"]].assign(error=errors)


def interquartile_mean(frame: pd.DataFrame, optima: Mapping[str, float] | None = None, seed: int = 0) -> pd.DataFrame:
    """Return one row an optimizer: problems, n (trials), and the interquartile mean of its normalised errors.

    ``iqm`` is the mean of the middle half of the :func:`normalised_errors` of all trials on all problems, low to
    high its 95 % percentile bootstrap interval, from 33 optimizers on of 999 resamples. It is +inf once more than a
    quarter of the trials failed, and missing without any problem that has trials of every optimizer. The scale of the
    errors is not resampled.
    """
    problems = complete_problems(frame)
    errors = normalised_errors(frame[frame["problem"].isin(problems)], optima)
    optimizers, rows = labels(frame, "optimizer"), []
    resamples = RESAMPLES if resampled(len(optimizers)) else FEWER
    for optimizer in optimizers:
        own = errors[errors["optimizer"] == optimizer]
        strata = [group.to_numpy() for _, group in own.groupby("problem", sort=False, observed=True)["error"]]
        iqm = float(trim_mean(own["error"], TRIMMED)) if strata else np.nan
        low, high = _interval(strata, resamples, seed) if strata and min(map(len, strata)) > 1 else (np.nan, np.nan)
        rows.append((optimizer, len(problems), len(own), iqm, low, high))
    return pd.DataFrame(rows, columns=["optimizer", "problems", "n", "iqm", "low", "high"])


def signed_ranks(difference: Floats, alpha: float = ALPHA) -> dict[str, Any]:
    """Return Wilcoxon's signed-rank test of (n,) differences, as in :func:`wilcoxon_tests`.

    Keys: statistic, p, note and, as ``lower``, the sum of ranks of the positive differences less that of the others.
    """
    size = merge_near_ties(np.abs(difference))
    ranks = rankdata(size)
    balance = float(np.sign(difference) @ ranks)
    differing = int(np.count_nonzero(size))  # numpy's own integer overflows in the power below
    result = {"statistic": (float(ranks.sum()) - abs(balance)) / 2, "p": 1.0, "lower": balance, "note": ""}
    if len(size) and differing == 0:
        return result | {"note": "identical"}
    if 2 / 2**differing > alpha:  # the smallest p there is: all signs alike
        return result | {"note": "untestable"}
    return result | {"p": _signed_rank_p(ranks[size > 0], balance)}


def _signed_rank_p(ranks: Floats, balance: float) -> float:
    """Return the chance that fair signs leave the sum of signed ranks as far from 0 as ``balance``.

    Equal to ``scipy.stats.wilcoxon(method="exact")``, which handles neither ties nor zeros.
    """
    doubled = np.rint(2 * ranks).astype(int)  # shared ranks are halves
    chances = _rank_sums(tuple(np.sort(doubled).tolist()))
    sums = 2 * np.arange(len(chances)) - doubled.sum()
    return float(min(chances[np.abs(sums) >= np.rint(2 * abs(balance))].sum(), 1.0))


@lru_cache(maxsize=1_000)
def _rank_sums(ranks: tuple[int, ...]) -> Floats:
    """Return the chance of each sum of the positive ranks, from 0 on, under fair signs."""
    chances = np.zeros(sum(ranks) + 1)
    chances[0], reached = 1.0, 1
    for rank in ranks:  # its sign adds the rank, or nothing
        reached += rank
        chances[rank:reached] += chances[: reached - rank].copy()
        chances[:reached] /= 2
    return chances


def _normalised(values: Floats, reference: float) -> Floats:
    """Return the scores of one problem as errors, 0 at the reference and 1 at their median."""
    merged = merge_near_ties(np.append(values, reference))
    errors, finite = merged[:-1], np.isfinite(merged[:-1])
    errors[finite] -= merged[-1]
    middle, largest = float(np.median(errors)), float(errors[finite].max(initial=0.0))
    return np.asarray(errors / (middle if 0 < middle < np.inf else largest if largest > 0 else 1.0))


def _interval(strata: list[Floats], resamples: int, seed: int) -> tuple[float, float]:
    """Return the 95 % interval of the interquartile mean of samples that are resampled separately."""

    def iqm(*samples: Floats, axis: int) -> Any:
        return trim_mean(np.concatenate(samples, axis=axis), TRIMMED, axis=axis)

    with np.errstate(invalid="ignore"):  # the library's own interval and error, both unused, fail on infinite errors
        found = bootstrap(
            strata,
            iqm,
            n_resamples=resamples,
            batch=BATCH,
            vectorized=True,
            method="percentile",
            random_state=np.random.default_rng(seed),
        )
    return percentile_interval(found.bootstrap_distribution)
