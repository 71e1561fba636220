"""Trial-based dominance: one order of trials by speed and accuracy, and the U-scores of optimizers in that order.

Of two trials that reached the target, the one with fewer evaluations wins; a trial that reached it wins over one that
did not; of two that did not, the one with the lower final value wins. What remains is a tie and counts half.

Source: K. V. Price, A. Kumar, P. N. Suganthan, "Trial-based dominance for comparing both the speed and accuracy of
stochastic optimizers with standard non-parametric tests", Swarm and Evolutionary Computation 78, 2023 (preprint:
arXiv:2212.09423), where U-scores determine the winners of the CEC 2022 competition.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from scipy.stats import rankdata

from bench.analysis.cells import Traces, labels, merge_near_ties, scores, traces_of
from bench.analysis.instances import SOLVED

COLUMNS = ("problem", "optimizer", "trials", "reached", "u", "pairs")


def u_scores(
    frame: pd.DataFrame, traces: Traces, optima: Mapping[str, float], precision: float = SOLVED
) -> pd.DataFrame:
    """Return one row a cell: problem, optimizer, trials, reached, u and pairs.

    ``u`` is the number of pairs that the optimizer's trials win against the trials of all others, ties counted half;
    ``pairs`` is the number of these pairs. With two optimizers, ``u`` is the Mann-Whitney U of the order of trials.
    ``reached`` counts the trials that came within ``precision`` of the optimum.

    Numbers of pairs can be added over problems only where every optimizer has the same number of trials: a problem of
    which this does not hold has no row, and neither has one without a known optimum. A failed trial reached nothing
    and ends at +inf. Final errors that are near-ties (equal to a relative 1e-10) are ties.

    Args:
        frame: the tidy frame.
        traces: of its trials.
        optima: the optimum by problem; no trial may be below it by more than rounding.
        precision: the target, as a distance from the optimum.
    """
    optimizers, rows = labels(frame, "optimizer"), []
    ordered = _placed(frame, traces, optima, precision)
    for problem in (label for label in labels(frame, "problem") if label in optima):
        trials = ordered[ordered["problem"] == problem]
        cells = [trials[trials["optimizer"] == optimizer] for optimizer in optimizers]
        n = len(cells[0]) if cells else 0
        if not n or any(len(cell) != n for cell in cells):
            continue
        for optimizer, cell in zip(optimizers, cells, strict=True):
            u = float(cell["points"].sum()) - n * (n + 1) / 2  # less the pairs among its own trials
            pairs = n * n * (len(optimizers) - 1)
            rows.append((problem, optimizer, n, int(np.isfinite(cell["reached"]).sum()), u, pairs))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def ordered_trials(
    frame: pd.DataFrame, traces: Traces, optima: Mapping[str, float], precision: float = SOLVED
) -> pd.DataFrame:
    """Return the trials on problems of ``optima``, with the rank of each on its problem, 1 the best, in place of fun.

    The ranks are those of trial-based dominance, so that any comparison of values by rank compares speed and accuracy.
    Arguments as of :func:`u_scores`.
    """
    ordered = _placed(frame, traces, optima, precision)
    trials = ordered.groupby("problem", observed=True)["points"].transform("size")
    return ordered.assign(fun=trials + 1 - ordered["points"]).drop(columns=["reached", "points"])


def _placed(frame: pd.DataFrame, traces: Traces, optima: Mapping[str, float], precision: float) -> pd.DataFrame:
    """Return the trials on problems of ``optima`` with two more columns.

    ``reached`` is the evaluation at which a trial was within the precision, infinite where it never was; ``points`` its
    rank on its problem from the worst, 1. Ties share their mean.
    """
    trials = frame[frame["problem"].isin(optima)]
    optimum = trials["problem"].astype(object).map(optima).astype(float)
    errors = (scores(trials) - optimum).clip(lower=0.0)
    reached = [
        np.append(trace.evaluations[trace.values - zero <= precision], np.inf)[0]
        for trace, zero in zip(traces_of(trials, traces), optimum, strict=True)
    ]
    outcomes, points = np.column_stack((np.array(reached), errors)), np.empty(len(trials))
    for rows in trials.groupby("problem", observed=True).indices.values():
        of_problem = outcomes[rows]
        late = np.isinf(of_problem[:, 0])
        of_problem[:, 1] = np.where(late, merge_near_ties(of_problem[:, 1]), 0.0)
        _, place = np.unique(of_problem, axis=0, return_inverse=True)  # in the order of evaluations, then of errors
        points[rows] = rankdata(-place.ravel())
    return trials.assign(reached=outcomes[:, 0], points=points)
