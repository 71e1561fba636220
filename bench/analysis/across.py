"""Tests and effect sizes across problems; pooling the trials of all problems would count one problem many times over.

The unit is the *block*: a problem, or several that resemble each other because they are steps of one sweep or one
function in several dimensions, which are no independent evidence. The value of a pair of optimizers on a problem is
A12 - 0.5, which means the same on every problem and needs no scale of their values; that of a block is the mean over
its problems. Lower is better; a failed trial is +inf. Only problems on which every optimizer has a trial count.

An interval for *these problems* shows how far other trials on the same problems could move a value; an interval for
*further problems*, of which these are taken for a sample, how far other problems could.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from math import factorial, inf
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import bootstrap, f, friedmanchisquare, norm, rankdata, t, trim_mean

from bench.analysis.cells import complete_problems, labels, merge_near_ties, reference_values, scores
from bench.analysis.direction import ALPHA, Effects, effects, mean_of, stacked, standardised, wilson_form
from bench.analysis.pairwise import RESAMPLES, holm, percentile_interval
from bench.analysis.standings import complete_ranks
from bench.typing import Floats

TRIMMED = 0.25  # from either end: the mean of the rest is the interquartile mean
BATCH = 1_000  # resamples at a time, to bound memory
MANY, FEWER = 32, 999  # more optimizers than these have fewer resamples each
FEWEST_BLOCKS = 3  # of an interval for further problems

Blocks = Mapping[str, str]  # the block of each problem; a problem that is not in it is one of its own


def ranks_by_block(standing: pd.DataFrame, blocks: Blocks | None = None) -> pd.DataFrame:
    """Return the mean rank of each optimizer in each block, blocks by optimizers.

    ``standing`` is that of :func:`bench.analysis.standings`. Only problems on which every optimizer has a rank count.
    """
    wide = complete_ranks(standing)
    return wide.groupby(_owners(wide.index, blocks), sort=False).mean().rename_axis(columns=None)


def friedman(ranks: pd.DataFrame) -> pd.DataFrame:
    """Test whether any optimizer ranks differently from the others over all blocks, in one row.

    ``ranks`` are those of :func:`ranks_by_block`. Columns: problems (the blocks), optimizers; ``statistic``, Friedman's
    chi-squared corrected for ties (Friedman 1937), and its p; ``iman_davenport``, the less conservative F of Iman and
    Davenport (1980, Communications in Statistics A9), its degrees of freedom df1 and df2, and p_iman_davenport;
    ``note``.

    The note is "too few optimizers" below three, "too few problems" below two, or "identical" where no problem ranks
    any two optimizers differently; the statistics are then missing and p = 1. Where all problems rank the optimizers
    alike F is infinite. Its p is never below k!^(1 - n), the chance of that agreement between n untied rankings.
    """
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


def wilcoxon_tests(pairs: pd.DataFrame, blocks: Blocks | None = None, alpha: float = ALPHA) -> pd.DataFrame:
    """Return Wilcoxon's signed-rank test of each pair of optimizers: is one lower on most blocks of problems?

    Columns: first, second, problems, blocks; ``statistic``, the smaller sum of ranks, its exact two-sided p; p_holm,
    adjusted over all pairs (Holm 1979); significant (p_holm <= alpha); ``lower``, the optimizer with the larger sum
    of ranks in its favour ("" where they are equal); ``note``, which is "identical" where no block differs and
    "untestable" where too few differ for any p <= alpha. Both have p = 1.

    What is ranked is A12 - 0.5. Where the trials of two optimizers have one distribution on every problem its sign is
    that of a fair coin, whatever the size, so the test is exact. The ranks of blocks without a difference are split
    between both sums (Demšar 2006, Journal of Machine Learning Research 7, section 3.1.3). p is exact also with ties:
    the share of all ways to sign the ranks that leave the sums as far apart.

    ``pairs`` are those of :func:`bench.analysis.pairwise_tests`.
    """
    wide = _by_problem(pairs, "a12")
    means = (wide - 0.5).groupby(_owners(wide.index, blocks), sort=False).mean().round(12)  # opposite values are 0
    rows: list[dict[str, Any]] = []
    for first, second in zip(*(means.columns.get_level_values(level) for level in (0, 1)), strict=True):
        test = signed_ranks(means[first, second].to_numpy(dtype=float), alpha)
        rows.append({"first": first, "second": second, "problems": len(wide), "blocks": len(means), **test})
    tests = pd.DataFrame(rows, columns=["first", "second", "problems", "blocks", "statistic", "p", "lower", "note"])
    return _decided(tests, tests["lower"].to_numpy(dtype=float), alpha)


def cliques(average_ranks: pd.Series[float], tests: pd.DataFrame) -> list[tuple[str, ...]]:
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
        while end < len(ordered) and not any(frozenset((label, ordered[end])) in apart for label in ordered[start:end]):
            end += 1
        if end > max(last, start + 1):
            groups.append(tuple(ordered[start:end]))
            last = end
    return groups


def stratified_tests(pairs: pd.DataFrame, blocks: Blocks | None = None, alpha: float = ALPHA) -> pd.DataFrame:
    """Return a test of each pair of optimizers on these problems alone: is the mean over problems of A12 0.5?

    Columns as of :func:`wilcoxon_tests`; ``statistic`` is the standardised mean, with the variance that A12 = 0.5 on
    every problem would have, and ``note`` is "untestable" where a cell has a single trial. It asks less than Wilcoxon's
    test does, whether other trials on the same problems would show the same, and holds for no further problems. p is
    never below the chance of complete separation on all of them.
    """
    chance, ratio, smaller = (_by_problem(pairs, name) for name in ("a12", "ratio", "smaller"))
    mean = chance.mean(axis=0).to_numpy() - 0.5
    size = np.abs(standardised(chance.to_numpy(), ratio.to_numpy()))
    p = np.maximum(2 * norm.sf(size), 2.0 ** (1 - smaller.to_numpy().sum(axis=0)))
    tested = np.isfinite(size)
    tests = pd.DataFrame(list(chance.columns), columns=["first", "second"]).assign(
        problems=len(chance), blocks=len(set(_owners(chance.index, blocks))), statistic=size, p=np.where(tested, p, 1.0)
    )
    tests["note"] = np.where(tested, "", "untestable")
    return _decided(tests, mean, alpha)


def _decided(tests: pd.DataFrame, balance: Floats, alpha: float) -> pd.DataFrame:
    """Return tests with p_holm, significant and lower; ``balance`` is above 0 where the first one is favoured."""
    columns = ["first", "second", "problems", "blocks", "statistic", "p", "p_holm", "significant", "lower", "note"]
    p_holm = holm(tests["p"].to_numpy(dtype=float))
    favoured = np.where(balance > 0, tests["first"], np.where(balance < 0, tests["second"], ""))
    return tests.assign(p_holm=p_holm, significant=p_holm <= alpha, lower=favoured)[columns]


def _by_problem(pairs: pd.DataFrame, column: str) -> pd.DataFrame:
    """Return a column of pairs, problems by pairs, of the problems on which every optimizer has a trial."""
    names = ["problem", "first", "second"]
    table = pairs.astype(dict.fromkeys(names, object)).assign(smaller=pairs[["n_first", "n_second"]].min(axis=1))
    order = list(table[names[1:]].drop_duplicates().itertuples(index=False, name=None))
    complete = table["smaller"].gt(0).groupby(table["problem"], sort=False).transform("all")
    wide = table[complete].pivot(index="problem", columns=names[1:], values=column).astype(float)
    return wide.reindex(
        index=table.loc[complete, "problem"].unique(), columns=pd.MultiIndex.from_tuples(order, names=names[1:])
    )


def _owners(problems: Iterable[Any], blocks: Blocks | None) -> NDArray[np.object_]:
    """Return the block of each problem, as an array: pandas would take a list of labels for names of columns."""
    return np.array([(blocks or {}).get(str(problem), str(problem)) for problem in problems], dtype=object)


def probability_of_improvement(pairs: pd.DataFrame, blocks: Blocks | None = None) -> pd.DataFrame:
    """Return the probability that a trial of ``first`` ends below one of ``second``, one row a pair.

    Columns: first, second, problems, blocks; ``probability``, the mean over problems of A12; low and high, its 95%
    interval for other trials on these problems, missing where a cell has a single trial; further_low and further_high,
    that of the mean over blocks for further problems, missing below three blocks. All is missing where no problem has
    trials of every optimizer.

    The variance of the mean for these problems is the sum of those of A12 (:mod:`bench.analysis.direction`); for
    further problems, it is that of the blocks' means, with Student's t.
    """
    wide = {name: _by_problem(pairs, name) for name in ("a12", "ratio", "smaller")}
    estimates = Effects(*(wide[name].to_numpy() for name in ("a12", "ratio", "smaller")))
    owners = _owners(wide["a12"].index, blocks)
    table = pd.DataFrame(list(wide["a12"].columns), columns=["first", "second"])
    means = wide["a12"].groupby(owners, sort=False).mean().to_numpy()
    mean = mean_of(estimates)
    low, high = wilson_form(mean.a12, mean.ratio)
    table = table.assign(problems=len(estimates.a12), blocks=len(means), probability=mean.a12, low=low, high=high)
    return table.assign(**_further(means))


def improvement_of(samples: Sequence[tuple[Floats, Floats]]) -> tuple[float, float, float]:
    """Return the probability that a value of the first of two samples ends lower, as a mean over problems, low to high.

    As :func:`probability_of_improvement` does; missing without any problem, and the interval where a sample has a
    single value.
    """
    if not samples:
        return np.nan, np.nan, np.nan
    mean = mean_of(stacked([effects(one[np.newaxis], rival[np.newaxis]) for one, rival in samples]))
    low, high = wilson_form(mean.a12, mean.ratio)
    return float(mean.a12[0]), float(low[0]), float(high[0])


def normalised_errors(frame: pd.DataFrame, optima: Mapping[str, float] | None = None) -> pd.DataFrame:
    """Return the error of each trial on a scale that all problems share: problem, optimizer, trial and error.

    0 is the reference value of the problem: its optimum, or the lowest score of all trials where the optimum is unknown
    or beaten (:func:`bench.analysis.reference_values`). 1 is the median error of all trials of all optimizers on the
    problem, or the largest finite error where that median is 0 or infinite. A failed trial has +inf; near-ties are
    ties. The scale depends on the optimizers compared.
    """
    by_problem = scores(frame).groupby(frame["problem"].astype(object))
    zero = reference_values({str(problem): least for problem, least in by_problem.min().items()}, optima)
    errors = by_problem.transform(lambda values: _normalised(values.to_numpy(), zero[str(values.name)].value))
    return frame[["problem", "optimizer", "trial"]].assign(error=errors)


def interquartile_mean(frame: pd.DataFrame, optima: Mapping[str, float] | None = None, seed: int = 0) -> pd.DataFrame:
    """Return one row an optimizer: problems, n (trials), and the interquartile mean of its normalised errors.

    ``iqm`` is the mean of the middle half of the :func:`normalised_errors` of all trials on all problems, low to
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


def _further(means: Floats, level: float = 0.95) -> dict[str, Floats]:
    """Return further_low and further_high of :func:`probability_of_improvement` from (blocks, pairs) means of A12."""
    blocks, pairs = means.shape
    missing = np.full(pairs, np.nan)
    if blocks < FEWEST_BLOCKS:
        return {"further_low": missing, "further_high": missing}
    centre, variance = means.mean(axis=0), means.var(axis=0, ddof=1) / blocks
    largest = centre * (1 - centre)
    ratio = np.divide(variance, largest, out=np.zeros(pairs), where=largest > 0)
    quantile = float(t.ppf((1 + level) / 2, blocks - 1))
    low, high = wilson_form(centre, ratio, quantile)
    # A mean of 0 or 1 on every block has a chance of at most its own size to the power of their number.
    apart, alone = ((1 - level) / 2) ** (1 / blocks), variance == 0
    return {
        "further_low": np.where(alone, np.minimum(low, apart), low),
        "further_high": np.where(alone, np.maximum(high, 1 - apart), high),
    }


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
