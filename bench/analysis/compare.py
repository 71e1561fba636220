"""What pairs and cells add up to: the thesis's comparison matrix, and who is ranked first on how many problems."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from bench.analysis.pairwise import ALPHA


@dataclass(frozen=True)
class Matrix:
    """The comparison matrix, problems by optimizers.

    Attributes:
        mean: the mean score, missing where a trial failed or none was made.
        best: whether a cell holds the lowest mean of its row (bold), in rows where at least two cells have a mean.
        alike: whether a cell that is not the best may come from the best one's distribution (italics).
    """

    mean: pd.DataFrame
    best: pd.DataFrame
    alike: pd.DataFrame


def comparison_matrix(summary: pd.DataFrame, pairs: pd.DataFrame, alpha: float = ALPHA) -> Matrix:
    """Return the matrix of thesis Table 7.2: mean, the best, and what an exact KS test cannot tell from the best.

    Args:
        summary: from :func:`bench.analysis.summarise`.
        pairs: from :func:`bench.analysis.pairwise_tests`; as in the thesis, the raw p is compared with ``alpha``.
        alpha: the level; an untestable pair (p = 1) counts as alike.
    """
    mean = _table(summary, "mean")
    best = mean.eq(mean.min(axis=1), axis=0) & (mean.notna().sum(axis=1) > 1).to_numpy()[:, np.newaxis]
    known = mean.notna()
    alike = pd.DataFrame(False, index=mean.index, columns=mean.columns)
    for pair in pairs[pairs["p"] > alpha].itertuples():
        for one, other in ((pair.first, pair.second), (pair.second, pair.first)):
            if best.at[pair.problem, one] and not best.at[pair.problem, other]:
                alike.at[pair.problem, other] = bool(known.at[pair.problem, other])
    return Matrix(mean, best, alike)


def ranking(summary: pd.DataFrame, pairs: pd.DataFrame, alpha: float = ALPHA) -> pd.DataFrame:
    """Return for each optimizer: problems, first, separable, mean_rank.

    The unit is the problem, its value the median score; problems are counted where every optimizer has a trial.
    ``first`` counts the problems with the lowest median (a tie counts for each), ``separable`` those of them where
    the optimizer differs from every rival (KS, Holm) and tends to be lower than each (A12 > 0.5).
    """
    median = _table(summary, "median").dropna()
    lowest = median.min(axis=1)
    first = median.eq(lowest, axis=0) & np.isfinite(lowest).to_numpy()[:, np.newaxis]
    beats = _beats(pairs, alpha)
    rivals = max(len(median.columns) - 1, 1)  # with no rival at all nothing is separable
    separable = [
        sum(len(beats.get((problem, optimizer), ())) == rivals for problem in median.index[first[optimizer]])
        for optimizer in median.columns
    ]
    return pd.DataFrame(
        {
            "optimizer": list(median.columns),
            "problems": len(median),
            "first": first.sum().to_numpy(),
            "separable": separable,
            "mean_rank": median.rank(axis=1).mean().to_numpy(),
        }
    )


def _beats(pairs: pd.DataFrame, alpha: float) -> dict[tuple[str, str], set[str]]:
    """Return for each (problem, optimizer) the rivals it is separable from and tends to be lower than."""
    beaten: dict[tuple[str, str], set[str]] = {}
    for pair in pairs[(pairs["p_holm"] <= alpha) & (pairs["lower"] != "")].itertuples():
        winner, one, other = str(pair.lower), str(pair.first), str(pair.second)
        beaten.setdefault((str(pair.problem), winner), set()).add(other if winner == one else one)
    return beaten


def _table(summary: pd.DataFrame, statistic: str) -> pd.DataFrame:
    """Return a statistic as problems by optimizers, in the summary's order."""
    order = {column: list(dict.fromkeys(summary[column])) for column in ("problem", "optimizer")}
    table = summary.pivot(index="problem", columns="optimizer", values=statistic).astype(float)
    return table.reindex(index=order["problem"], columns=order["optimizer"]).rename_axis(columns=None)
