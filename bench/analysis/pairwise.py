"""Pairs of optimizers on one problem: which of them is lower, by how much, and whether their distributions differ."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.analysis import direction
from bench.analysis.cells import labels
from bench.analysis.direction import ALPHA
from bench.analysis.kolmogorov_smirnov import ks_tests
from bench.analysis.strata import Samples, strata
from bench.typing import Flags, Floats

RESAMPLES = 9_999  # of every bootstrap; with the sample itself 10,000
CUTOFFS = {"large": 0.71, "medium": 0.64, "small": 0.56}  # Vargha and Delaney 2000, Table 1
AT_ONCE = 2_000  # pairs of samples in memory

COLUMNS = (
    "problem", "first", "second", "n_first", "n_second", "a12", "ratio", "a12_low", "a12_high", "joint_low",
    "joint_high", "p", "p_holm", "significant", "lower", "testable", "separated", "ks_distance",
    "ks_p", "ks_tied",
)  # fmt: skip


def pairwise_tests(frame: pd.DataFrame, alpha: float = ALPHA, subject: str = "") -> pd.DataFrame:
    """Return one row a problem and pair of optimizers.

    The size: a12, the chance that a trial of ``first`` ends below one of ``second``, ties counted half, of pooled
    instances the mean of that within each of them (:mod:`bench.analysis.strata`), with the 95%
    interval a12_low to a12_high, and joint_low to joint_high, intervals of which all together hold with 1 - ``alpha``
    (Bonferroni); ratio, the variance of a12 over a12 (1 - a12) (:mod:`bench.analysis.direction`); separated, whether
    a12 is 0 or 1.

    The test of its direction: p, of the hypothesis a12 = 0.5, which allows that the spreads differ
    (:mod:`bench.analysis.direction`); p_holm, adjusted over all rows, so over pairs and problems (Holm 1979);
    significant (p_holm <= ``alpha``); lower, the optimizer that is *separably lower*, "" where the row is not
    significant; testable, whether complete separation would be significant beside as many rows.

    The thesis's test of one distribution, unadjusted: ks_distance, ks_p and ks_tied
    (:mod:`bench.analysis.kolmogorov_smirnov`).

    Assumptions: trials are independent. Failed trials count as +inf, near-ties as ties. A pair of which a cell has
    fewer than two trials has no interval and p = 1, and is no hypothesis of the adjustment where a cell has none.
    With a ``subject``, only its pairs are hypotheses; the others have no p_holm and are never significant.
    Names are categories: texts would take most of the memory.
    """
    by_problem, optimizers, problems = strata(frame), labels(frame, "optimizer"), labels(frame, "problem")
    sizes = np.array(
        [[sum(map(len, samples)) for samples in zip(*by_problem[problem], strict=True)] for problem in problems],
        dtype=np.int64,
    )
    one, other = np.triu_indices(len(optimizers), 1)
    tested = np.array([subject in ("", optimizers[i], optimizers[j]) for i, j in zip(one, other, strict=True)], bool)
    tests = int(np.sum((np.minimum(sizes[:, one], sizes[:, other]) > 0) & tested)) if len(problems) else 0
    # Of each column one array from the beginning: many small ones would leave gaps in the memory.
    columns: dict[str, Any] = {}
    for place, problem in enumerate(problems):
        compared = compare_all(by_problem[problem], 1 - alpha / max(tests, 1))
        for name, values in compared.items():
            every = columns.setdefault(name, np.empty((len(problems), len(one)), dtype=values.dtype))
            every[place] = values
    columns = {name: every.ravel() for name, every in columns.items()}
    names: dict[str, tuple[Any, Sequence[str]]] = {
        "problem": (np.repeat(np.arange(len(problems)), len(one)), problems),
        "first": (np.tile(one, len(problems)), optimizers),
        "second": (np.tile(other, len(problems)), optimizers),
    }
    columns |= {
        name: pd.Categorical.from_codes(codes, pd.Index(categories)) for name, (codes, categories) in names.items()
    }
    pairs = pd.DataFrame(columns, columns=list(COLUMNS), copy=False)
    smaller = pairs[["n_first", "n_second"]].min(axis=1).to_numpy(dtype=float)
    return adjusted(pairs, alpha, subject).assign(
        testable=(2.0 ** (1 - smaller) * max(tests, 1) <= alpha) & of_subject(pairs, subject),
        separated=pairs["a12"].isin((0.0, 1.0)),
        ks_tied=pairs["ks_tied"].eq(True),
    )


def adjusted(pairs: pd.DataFrame, alpha: float = ALPHA, subject: str = "") -> pd.DataFrame:
    """Return the rows of :func:`pairwise_tests` with what follows from p and a12 of all rows, or of a subject's."""
    tested = of_subject(pairs, subject)
    present = ((pairs["n_first"] > 0) & (pairs["n_second"] > 0)).to_numpy(dtype=bool) & tested
    p_holm = np.where(tested, 1.0, np.nan)
    p_holm[present] = holm(pairs["p"].to_numpy(dtype=float)[present])
    significant, chance = p_holm <= alpha, pairs["a12"].to_numpy(dtype=float)
    first, second = (pairs[name].cat.codes.to_numpy(dtype=np.int64) for name in ("first", "second"))
    lower = np.where(significant & (chance > 0.5), first + 1, np.where(significant & (chance < 0.5), second + 1, 0))
    names = pd.Index(["", *pairs["first"].cat.categories])
    return pairs.assign(p_holm=p_holm, significant=significant, lower=pd.Categorical.from_codes(lower, names))


def of_subject(pairs: pd.DataFrame, subject: str) -> Flags:
    """Return a flag for each row: True where the subject is first or second; all True without a subject."""
    if not subject:
        return np.ones(len(pairs), dtype=bool)
    return ((pairs["first"] == subject) | (pairs["second"] == subject)).to_numpy(dtype=bool)


def seen_from(pairs: pd.DataFrame, optimizer: str) -> pd.DataFrame:
    """Return the pairs of an optimizer, with A12 as the chance that it ends lower than the ``second`` one."""
    turned = pairs[pairs["second"] == optimizer].rename(columns={"first": "second", "second": "first"})
    turned = turned.assign(a12=1 - turned["a12"])
    return pd.concat([pairs[pairs["first"] == optimizer], turned])


def holm(p: Floats) -> Floats:
    """Return the p-values, (k,), adjusted for k hypotheses (Holm 1979, Scandinavian Journal of Statistics 6)."""
    order = np.argsort(p)
    steps = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    return np.minimum(steps, 1.0)[np.argsort(order)]


def effect_size(a12: float) -> str:
    """Return Vargha and Delaney's (2000) category of an A12 in either direction, "" where it is missing."""
    if np.isnan(a12):
        return ""
    size = max(a12, 1 - a12)
    return next((word for word, least in CUTOFFS.items() if size >= least), "negligible")


def compare_all(by_stratum: Sequence[Samples], joint: float = 0.95) -> dict[str, Any]:
    """Return those columns of :func:`pairwise_tests` that need the k samples of one problem alone, by stratum.

    Each has k (k - 1) / 2 values, one a pair, in the order of :func:`itertools.combinations`. Pairs of equal sizes are
    compared at once. ``joint`` is the level of the joint intervals.
    """
    samples = [np.concatenate(own) for own in zip(*by_stratum, strict=True)]
    one, other = np.triu_indices(len(samples), 1)
    sizes = np.array([len(sample) for sample in samples], dtype=np.int64)
    estimates = direction.stratified([_estimates(own) for own in by_stratum])
    p = direction.p_values(estimates)
    columns: dict[str, Any] = {
        "n_first": sizes[one], "n_second": sizes[other], "a12": estimates.a12, "ratio": estimates.ratio,
        "p": np.where(np.isnan(p), 1.0, p), "ks_distance": np.full(len(one), np.nan), "ks_p": np.ones(len(one)),
        "ks_tied": np.zeros(len(one), dtype=bool),
    }  # fmt: skip
    columns["a12_low"], columns["a12_high"] = direction.intervals(estimates)
    columns["joint_low"], columns["joint_high"] = direction.intervals(estimates, joint)
    for places, these, others in alike(samples):
        if min(these.shape[1], others.shape[1]):
            for name, values in ks_tests(these, others).items():
                columns[name][places] = values
    return columns


def _estimates(samples: Samples) -> direction.Effects:
    """Return A12 of each pair of k samples, all missing where one is empty."""
    chance, ratio, smaller = np.full((3, len(samples) * (len(samples) - 1) // 2), np.nan)
    for places, these, others in alike(samples):
        if min(these.shape[1], others.shape[1]):
            chance[places], ratio[places], smaller[places] = direction.effects(these, others)
    return direction.Effects(chance, ratio, smaller)


def alike(samples: Sequence[Floats]) -> Iterator[tuple[NDArray[np.intp], Floats, Floats]]:
    """Yield the pairs of k samples, many of the same sizes n and m at once.

    Yields their places in the order of :func:`itertools.combinations`, (g,), and the values, (g, n) and (g, m).
    """
    one, other = np.triu_indices(len(samples), 1)
    sizes = np.array([len(sample) for sample in samples], dtype=np.int64)
    n, m = sizes[one], sizes[other]
    for sizes_of_pair in sorted(set(zip(n.tolist(), m.tolist(), strict=True))):
        same = np.flatnonzero((n == sizes_of_pair[0]) & (m == sizes_of_pair[1]))
        for part in np.split(same, range(AT_ONCE, len(same), AT_ONCE)):
            these, others = (np.array([samples[i] for i in places[part]]) for places in (one, other))
            yield part, these, others
