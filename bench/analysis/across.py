"""Tests and effect sizes across problems; pooling the trials of all problems would count one problem many times over.

The quantity is the *probability to end lower*: the mean over problems of A12, the chance that a run of one optimizer
ends lower than a run of another, ties counted half. A12 means the same on every problem and needs no scale of values.
Lower is better; a failed trial is +inf. Only problems on which every optimizer has a trial count.

Whatever the problems are, the runs are independent: the claim is that other runs on these problems would show the same.
It says nothing of further problems.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from math import factorial, inf
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import bootstrap, f, friedmanchisquare, norm, studentized_range, trim_mean

from bench.analysis.cells import complete_problems, labels, merge_near_ties, reference_values, scores
from bench.analysis.direction import (
    ALPHA,
    Effects,
    intervals,
    least_p,
    mean_of,
    standardised,
)
from bench.analysis.pairwise import RESAMPLES, holm, of_subject, percentile_interval
from bench.analysis.standings import against_rivals, matrices, ranks
from bench.errors import BenchError
from bench.typing import Floats

TRIMMED = 0.25  # from either end: the mean of the rest is the interquartile mean
BATCH = 1_000  # resamples at a time, to bound memory
TIED = 1e-12  # a mean of A12 this close to 0.5 is a rounded 0.5
MANY, FEWER = 32, 999  # more optimizers than these have fewer resamples each


def friedman(ranks: pd.DataFrame) -> pd.DataFrame:
    """Test whether any optimizer ranks differently from the others over all problems, in one row.

    ``ranks`` are those of :func:`bench.analysis.standings.complete_ranks`. Columns: problems, optimizers;
    ``statistic``, Friedman's chi-squared corrected for ties (Friedman 1937), and its p; ``iman_davenport``, the less
    conservative F of Iman and Davenport (1980, Communications in Statistics A9), its degrees of freedom df1 and df2,
    and p_iman_davenport; ``note``.

    The note is "too few optimizers" below three, "too few problems" below two, or "identical" where no problem ranks
    any two optimizers differently; the statistics are then missing and p = 1. Where all problems rank the optimizers
    alike F is infinite. Its p is never below k!^(1 - n), the chance of that agreement between n untied rankings.
    """
    if len(others := ranks.select_dtypes(exclude="number").columns):
        raise BenchError(f"friedman takes ranks, problems by optimizers, and the column {others[0]!r} holds no numbers")
    n, k = ranks.shape
    ranks = ranks.rank(axis=1)
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


def across_problems(pairs: pd.DataFrame, alpha: float = ALPHA, subject: str = "") -> pd.DataFrame:
    """Return one row a pair of optimizers: the probability that a run of ``first`` ends lower than one of ``second``.

    Columns: first, second, problems; ``probability``, the mean over problems of A12, with its 95% interval for
    other runs on these problems, low to high, and joint_low to joint_high, intervals of which all together hold with
    95% (Bonferroni); ``p`` of the test that it is 0.5 (:func:`p_of_means`), p_holm, adjusted over all pairs,
    significant (p_holm <= alpha) and ``lower``, the optimizer that ends lower more probably ("" where neither does).
    A cell with a single trial leaves no variance of runs: then p = 1, and no interval is known.

    ``pairs`` are those of :func:`bench.analysis.pairwise_tests`. All is missing where no problem has trials of every
    optimizer, and the p-values are 1. With a ``subject``, only its pairs are hypotheses, over which p_holm is adjusted
    and the joint intervals hold; the others have no p_holm and are never significant.
    """
    table, problems, estimates = _by_problem(pairs)
    p = p_of_means(estimates)
    tested = of_subject(table, subject)
    p_holm = np.full(len(table), np.nan)
    p_holm[tested] = holm(p[tested])
    mean = mean_of(estimates)
    balance = np.round(mean.a12 - 0.5, 12)
    favoured = np.where(balance > 0, table["first"], np.where(balance < 0, table["second"], ""))
    table = table.assign(problems=len(problems), probability=mean.a12)
    for prefix, level in (("", 0.95), ("joint_", 1 - 0.05 / max(int(tested.sum()), 1))):
        low, high = intervals(mean, level)
        table = table.assign(**{f"{prefix}low": low, f"{prefix}high": high})
    return table.assign(p=p, p_holm=p_holm, significant=p_holm <= alpha, lower=favoured)


def places(tests: pd.DataFrame, optimizers: Sequence[str]) -> pd.DataFrame:
    """Return the place of each optimizer over all problems: optimizer, place, beaten and chance.

    ``beaten`` is the number of rivals that it beats, with a probability to end lower above 0.5, a tie counted half;
    ``chance`` the mean of this probability over its rivals, which decides between optimizers that beat as many. Those
    that tie share their mean place. ``tests`` are those of :func:`across_problems`.
    """
    chances, _ = matrices(tests.rename(columns={"probability": "a12"}).fillna({"a12": 0.5}), optimizers)
    chances = np.where(np.abs(chances - 0.5) < TIED, 0.5, chances)
    beaten, chance = against_rivals(chances, axis=1)
    return pd.DataFrame({"optimizer": optimizers, "place": ranks(beaten, chance), "beaten": beaten, "chance": chance})


def with_winner(tests: pd.DataFrame, optimizers: Sequence[str], level: float) -> pd.DataFrame:
    """Return the tests with those of a winner significant, which need no adjustment as all of them must reject.

    A winner is the only first one of :func:`places`, where p is at most the level against each rival (an
    intersection-union test; Berger 1982). ``tests`` are those of :func:`across_problems`.
    """
    table = places(tests, optimizers)
    leaders = table.loc[table["place"] == table["place"].min(), "optimizer"]
    own = tests[["first", "second"]].isin([leaders.iloc[0]]).any(axis=1)
    lower = (tests["lower"] == leaders.iloc[0]) & (tests["p"] <= level)
    wins = len(leaders) == 1 and bool(lower[own].all())
    return tests.assign(significant=tests["significant"] | (own & wins))


def p_of_means(estimates: Effects) -> Floats:
    """Return the two-sided p-values, (g,), that the means of independent A12, (problems, g), are 0.5.

    The variance is the one of A12 = 0.5 on every problem, the largest there is, and p is never below the chance of
    complete separation on all of them. Where a cell has a single trial nothing is tested: p is 1.
    """
    chance, ratio, _ = estimates
    size = np.abs(standardised(chance, ratio))
    p = np.asarray(np.maximum(2 * norm.sf(size), least_p(mean_of(estimates).smaller)))
    return np.asarray(np.nan_to_num(p, nan=1.0))  # identical constants, or no problem


def cliques(average_ranks: pd.Series[float], tests: pd.DataFrame) -> list[tuple[str, ...]]:
    """Return the groups of at least two optimizers, neighbours by average rank, of which no pair differs significantly.

    ``tests`` are those of :func:`across_problems`, or of :func:`nemenyi`. The first depend on the two optimizers alone,
    unlike differences of average ranks (Benavoli, Corani and Mangili 2016, Journal of Machine Learning Research 17).
    Only the largest groups are returned: the bars of a critical-difference diagram.
    """
    ordered = [str(label) for label in average_ranks.dropna().sort_values(kind="stable").index]
    first, second, clear = (tests[name] for name in ("first", "second", "significant"))
    apart = {frozenset(pair) for *pair, differs in zip(first, second, clear, strict=True) if differs}
    groups: list[tuple[str, ...]] = []
    last = 0
    for start in range(len(ordered)):
        end = start + 1
        while end < len(ordered) and not any(frozenset((label, ordered[end])) in apart for label in ordered[start:end]):
            end += 1
        if end > max(last, start + 1):
            groups.append(tuple(ordered[start:end]))
            last = end
    return groups


def nemenyi(average_ranks: pd.Series[float], problems: int, alpha: float = ALPHA) -> tuple[float, pd.DataFrame]:
    """Return the critical difference of average ranks by Nemenyi's test, and its pairs: first, second, significant.

    Two of k optimizers differ where their average ranks over N ``problems`` do by q (k (k + 1) / 6 N)^1/2 or more, with
    q the quantile of the studentized range for k and infinite degrees of freedom over the root of 2 (Demšar 2006,
    section 3.2.2). The problems are taken for an independent sample, and whether two differ depends on who else is
    compared: :func:`across_problems` does without either.
    """
    ranked = average_ranks.dropna()
    optimizers = len(ranked)
    quantile = float(studentized_range.ppf(1 - alpha, optimizers, inf)) / 2**0.5
    difference = quantile * (optimizers * (optimizers + 1) / (6 * problems)) ** 0.5
    rows = [
        (first, second, bool(abs(ranked[first] - ranked[second]) >= difference))
        for first, second in combinations(ranked.index, 2)
    ]
    return difference, pd.DataFrame(rows, columns=["first", "second", "significant"])


def _by_problem(pairs: pd.DataFrame) -> tuple[pd.DataFrame, list[str], Effects]:
    """Return the pairs, the problems on which every optimizer has a trial, and the estimates, problems by pairs."""
    names = ["first", "second"]
    order = pairs[names].drop_duplicates().astype(object).reset_index(drop=True)
    place = pairs.groupby(names, sort=False, observed=True).ngroup().to_numpy()
    smaller = pairs[["n_first", "n_second"]].min(axis=1)
    complete = smaller.gt(0).groupby(pairs["problem"], sort=False, observed=True).transform("all").to_numpy()
    row, problems = pd.factorize(pairs["problem"].astype(object)[complete])
    wide = np.full((3, len(problems), len(order)), np.nan)
    for values, column in zip(wide, (pairs["a12"], pairs["ratio"], smaller), strict=True):
        values[row, place[complete]] = column[complete]
    return order, list(problems), Effects(*wide)


def normalised_errors(frame: pd.DataFrame, optima: Mapping[str, float] | None = None) -> pd.DataFrame:
    """Return the error of each trial on a scale that all problems share: problem, optimizer, trial and error.

    0 is the reference value of the problem: its optimum, or the lowest score of all trials where the optimum is unknown
    or beaten (``bench.analysis.reference_values``). 1 is the median error of all trials of all optimizers on the
    problem, or the largest finite error where that median is 0 or infinite. A failed trial has +inf; near-ties are
    ties. The scale depends on the optimizers compared.
    """
    by_problem = scores(frame).groupby(frame["problem"].astype(object))
    zero = reference_values({str(problem): least for problem, least in by_problem.min().items()}, optima)
    errors = by_problem.transform(lambda values: _normalised(values.to_numpy(), zero[str(values.name)].value))
    return frame[["problem", "optimizer", "trial"]].assign(error=errors)


def interquartile_mean(frame: pd.DataFrame, optima: Mapping[str, float] | None = None, seed: int = 0) -> pd.DataFrame:
    """Return one row an optimizer: problems, n (trials), and the interquartile mean of its normalised errors.

    ``iqm`` is the mean of the middle half of the ``normalised_errors`` of all trials on all problems, low to
    high its 95% percentile bootstrap interval, from 33 optimizers on of 999 resamples. It is +inf once more than a
    quarter of the trials failed, and missing without any problem that has trials of every optimizer. The scale of the
    errors is not resampled.
    """
    problems = complete_problems(frame)
    errors = normalised_errors(frame[frame["problem"].isin(problems)], optima)
    optimizers, rows = labels(frame, "optimizer"), []
    resamples = RESAMPLES if len(optimizers) <= MANY else FEWER
    for optimizer in optimizers:
        of_optimizer = errors[errors["optimizer"] == optimizer]
        strata = [group.to_numpy() for _, group in of_optimizer.groupby("problem", sort=False, observed=True)["error"]]
        iqm = float(trim_mean(of_optimizer["error"], TRIMMED)) if strata else np.nan
        low, high = _interval(strata, resamples, seed) if strata and min(map(len, strata)) > 1 else (np.nan, np.nan)
        rows.append((optimizer, len(problems), len(of_optimizer), iqm, low, high))
    return pd.DataFrame(rows, columns=["optimizer", "problems", "n", "iqm", "low", "high"])


def _normalised(values: Floats, reference: float) -> Floats:
    """Return the scores of one problem as errors, 0 at the reference and 1 at their median."""
    merged = merge_near_ties(np.append(values, reference))
    errors, finite = merged[:-1], np.isfinite(merged[:-1])
    errors[finite] -= merged[-1]
    middle, largest = float(np.median(errors)), float(errors[finite].max(initial=0.0))
    return np.asarray(errors / (middle if 0 < middle < np.inf else largest if largest > 0 else 1.0))


def _interval(strata: list[Floats], resamples: int, seed: int) -> tuple[float, float]:
    """Return the 95% interval of the interquartile mean of samples that are resampled separately."""

    def iqm(*samples: Floats, axis: int) -> Any:
        return trim_mean(np.concatenate(samples, axis=axis), TRIMMED, axis=axis)

    with np.errstate(invalid="ignore"):  # the library's own interval and error, both unused, fail on infinite errors
        resampled = bootstrap(
            strata,
            iqm,
            n_resamples=resamples,
            batch=BATCH,
            vectorized=True,
            method="percentile",
            random_state=np.random.default_rng(seed),
        )
    return percentile_interval(resampled.bootstrap_distribution)
