"""Tests and effect sizes across problems; pooling the trials of all problems would count one problem many times over.

The quantity is the *probability to end lower*: the mean over problems of A12, the chance that a run of one optimizer
ends lower than a run of another, ties counted half. A12 means the same on every problem and needs no scale of values.
Lower is better; a failed trial is +inf. Only problems on which every optimizer has a trial count.

Whatever the problems are, the runs are independent: the claim is that other runs on these problems would show the same.
It says nothing of further problems.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy.stats import norm

from bench.analysis.direction import (
    ALPHA,
    Effects,
    intervals,
    least_p,
    mean_of,
    standardised,
)
from bench.analysis.pairwise import holm, of_subject
from bench.analysis.standings import matrices, mean_chance, ranks
from bench.typing import Floats


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
    """Return the place of each optimizer over all problems: optimizer, place and chance.

    ``chance`` is the mean of the probability to end lower over its rivals, the highest first. Those that tie share
    their mean place. ``tests`` are those of :func:`across_problems`.
    """
    chances, _ = matrices(tests.rename(columns={"probability": "a12"}).fillna({"a12": 0.5}), optimizers)
    chance = mean_chance(chances)
    return pd.DataFrame({"optimizer": optimizers, "place": ranks(chance), "chance": chance})


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
