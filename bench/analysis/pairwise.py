"""Pairs of optimizers on one problem: which of them is lower, by how much, and whether their distributions differ."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.analysis import direction
from bench.analysis.cells import labels
from bench.analysis.direction import ALPHA
from bench.analysis.kolmogorov_smirnov import ks_tests
from bench.analysis.strata import Samples, strata
from bench.contract.typing import Flags, Floats

CUTOFFS = {"large": 0.71, "medium": 0.64, "small": 0.56}  # Vargha and Delaney 2000, Table 1
AT_ONCE = 2_000  # pairs of samples in memory

COLUMNS = (
    "problem", "first", "second", "n_first", "n_second", "a12", "ratio", "a12_low", "a12_high", "p", "p_holm", "level",
    "low", "high", "significant", "lower", "ks_distance", "ks_p", "ks_tied",
)  # fmt: skip

Pairs = tuple[NDArray[np.intp], NDArray[np.intp]]  # the places of the first and of the second samples


def pairwise_tests(
    frame: pd.DataFrame, alpha: float = ALPHA, subject: str = "", kept: Collection[str] | None = None
) -> pd.DataFrame:
    """Return one row a problem and pair of optimizers.

    The size: a12, the chance that a trial of ``first`` ends below one of ``second``, ties counted half, of pooled
    instances the mean of that within each of them (:mod:`bench.analysis.strata`), with the 95% interval a12_low to
    a12_high; ratio, the variance of a12 over a12 (1 - a12) (:mod:`bench.analysis.direction`); and p, of the hypothesis
    a12 = 0.5, which allows that the spreads differ.

    The claim: p_holm, adjusted within the problem (Holm 1979), missing where a pair is no hypothesis; ``level``, at
    which a pair was tested: ``alpha`` over the hypotheses that were left at its step, and for those that are not
    rejected, over those that were left at the last step; low to high, the interval of a12 of this level, which holds
    0.5 just where the pair is not ``significant``; and ``lower``, the optimizer that then ends lower, else "".

    The thesis's test of one distribution, unadjusted: ks_distance, ks_p and ks_tied
    (:mod:`bench.analysis.kolmogorov_smirnov`).

    Assumptions: trials are independent. Failed trials count as +inf, near-ties as ties. A pair of which a cell has
    fewer than two trials has no interval and p = 1, and is no hypothesis where a cell has none. Names are categories:
    texts would take most of the memory.

    Args:
        frame: the tidy frame.
        alpha: the level of each problem.
        subject: the optimizer whose pairs alone are hypotheses; "" for all.
        kept: the optimizers that one of a row's two is, by default any. All pairs are tested, and the clearest one of
            each problem has a row in any case.
    """
    optimizers, tables = labels(frame, "optimizer"), list[pd.DataFrame]()
    one, other = np.triu_indices(len(optimizers), 1)
    pairs = [*combinations(optimizers, 2)]
    own, wanted = (
        np.array([chosen is None or bool({first, second} & {*chosen}) for first, second in pairs], dtype=bool)
        for chosen in ([subject] if subject else None, kept)
    )
    problems = pd.Index(labels(frame, "problem"))
    for place, groups in enumerate(strata(frame).values()):
        samples = [np.concatenate(of_one) for of_one in zip(*groups, strict=True)]
        columns = _directions(groups, np.array([len(sample) for sample in samples], dtype=np.int64), own, alpha)
        known = np.flatnonzero(~np.isnan(columns["p_holm"]))
        clearest = known[columns["p_holm"][known].argsort(kind="stable")[:1]]
        rows = np.union1d(np.flatnonzero(wanted), clearest)
        columns = {name: values[rows] for name, values in columns.items()}
        columns |= _distributions(samples, (one[rows], other[rows]))
        named = {
            "problem": (np.full(len(rows), place), problems),
            "first": (one[rows], pd.Index(optimizers)),
            "second": (other[rows], pd.Index(optimizers)),
            "lower": (columns["lower"], pd.Index(["", *optimizers])),
        }
        columns |= {name: pd.Categorical.from_codes(*codes) for name, codes in named.items()}
        tables.append(pd.DataFrame(columns, columns=list(COLUMNS)))
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=list(COLUMNS))


def _directions(groups: Sequence[Samples], sizes: NDArray[np.int64], own: Flags, alpha: float) -> dict[str, Any]:
    """Return the columns on the direction of each pair of k optimizers on one problem; ``lower`` is a place from 1."""
    one, other = np.triu_indices(len(sizes), 1)
    estimates = direction.stratified([_estimates(samples) for samples in groups])
    p, smaller = direction.p_values(estimates), np.minimum(sizes[one], sizes[other])
    found = estimates._replace(smaller=np.maximum(smaller, 1).astype(np.float64))
    claim, tested = direction.inference(found, alpha)[2], own & (smaller > 0)
    adjusted, level = np.full((2, len(one)), np.nan)
    adjusted[tested] = holm(claim[tested])
    number, clear = int(tested.sum()), adjusted <= alpha
    left = number - np.argsort(np.argsort(claim[tested], kind="stable"), kind="stable")
    level[tested] = alpha / np.where(clear[tested], left, max(number - int(clear.sum()), 1))
    a12_low, a12_high = direction.intervals(estimates)
    low, high, _ = direction.inference(found, level)
    return {
        "n_first": sizes[one], "n_second": sizes[other], "a12": found.a12, "ratio": found.ratio, "a12_low": a12_low,
        "a12_high": a12_high, "p": np.where(np.isnan(p), 1.0, p), "p_holm": adjusted, "level": level, "low": low,
        "high": high, "significant": clear, "lower": np.where(clear, np.where(found.a12 > 0.5, one, other) + 1, 0),
    }  # fmt: skip


def _distributions(samples: Samples, pairs: Pairs) -> dict[str, Floats | Flags]:
    """Return the columns on whether the distributions of pairs of samples differ, as far as none is empty."""
    size = len(pairs[0])
    columns = {"ks_distance": np.full(size, np.nan), "ks_p": np.ones(size), "ks_tied": np.zeros(size, dtype=bool)}
    for places, these, others in alike(samples, pairs):
        for name, values in ks_tests(these, others).items():
            columns[name][places] = values
    return columns


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


def _estimates(samples: Samples) -> direction.Effects:
    """Return A12 of each pair of k samples, all missing where one is empty."""
    pairs = np.triu_indices(len(samples), 1)
    chance, ratio, smaller = np.full((3, len(pairs[0])), np.nan)
    for places, these, others in alike(samples, pairs):
        chance[places], ratio[places], smaller[places] = direction.effects(these, others)
    return direction.Effects(chance, ratio, smaller)


def alike(samples: Samples, pairs: Pairs) -> Iterator[tuple[NDArray[np.intp], Floats, Floats]]:
    """Yield pairs of samples, none of which is empty, many of the same sizes n and m at once.

    Yields their places among the pairs, (g,), and the values, (g, n) and (g, m).
    """
    sizes = np.array([len(sample) for sample in samples], dtype=np.int64)
    n, m = (sizes[side] for side in pairs)
    for of_these, of_others in sorted(set(zip(n.tolist(), m.tolist(), strict=True))):
        same = np.flatnonzero((n == of_these) & (m == of_others))
        for part in np.split(same, range(AT_ONCE, len(same), AT_ONCE)) if min(of_these, of_others) else ():
            these, others = (np.array([samples[i] for i in side[part]]) for side in pairs)
            yield part, these, others
