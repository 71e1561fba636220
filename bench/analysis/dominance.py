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

from bench.analysis.cells import Traces, labels, merge_near_ties, scores
from bench.analysis.instances import SOLVED
from bench.typing import Floats

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
    optimizers = labels(frame, "optimizer")
    values = scores(frame)
    rows = []
    for problem in labels(frame, "problem"):
        at = frame["problem"] == problem
        trials = frame.loc[at, ["optimizer", "trial"]]
        counts = trials["optimizer"].astype(object).value_counts().reindex(optimizers, fill_value=0)
        if problem not in optima or counts.nunique() != 1 or not counts.iloc[0]:
            continue
        reached, points = _points(
            trials, np.asarray(values[at], dtype=np.float64), traces, problem, optima[problem], precision
        )
        n = int(counts.iloc[0])
        for optimizer in optimizers:
            mine = (trials["optimizer"] == optimizer).to_numpy()
            u = float(points[mine].sum()) - n * (n + 1) / 2  # less the pairs among its own trials
            pairs = n * n * (len(optimizers) - 1)
            rows.append((problem, optimizer, n, int(np.isfinite(reached[mine]).sum()), u, pairs))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def ordered_trials(
    frame: pd.DataFrame, traces: Traces, optima: Mapping[str, float], precision: float = SOLVED
) -> pd.DataFrame:
    """Return the trials on problems of ``optima``, with the rank of each on its problem, 1 the best, in place of fun.

    The ranks are those of trial-based dominance, so that any comparison of values by rank compares speed and accuracy.
    Arguments as of :func:`u_scores`.
    """
    values, rank = scores(frame), pd.Series(np.nan, index=frame.index)
    for problem, optimum in optima.items():
        at = frame["problem"] == problem
        trials = frame.loc[at, ["optimizer", "trial"]]
        rank[at] = (
            len(trials)
            + 1
            - _points(trials, np.asarray(values[at], dtype=np.float64), traces, problem, optimum, precision)[1]
        )
    return frame.assign(fun=rank)[frame["problem"].isin(optima)]


def _points(
    trials: pd.DataFrame, values: Floats, traces: Traces, problem: str, optimum: float, precision: float
) -> tuple[Floats, Floats]:
    """Return the evaluations of each trial to the target, and its rank from the worst, 1; ties share their mean."""
    errors = np.maximum(values - optimum, 0.0)
    trial_traces = (
        traces.get((problem, optimizer, trial)) for optimizer, trial in trials.itertuples(index=False, name=None)
    )
    # A failed trial may have left a trace; its +inf says that it counts for nothing.
    reached = np.array([
        np.inf if trace is None or not np.isfinite(error)
        else np.append(trace.evaluations[trace.values - optimum <= precision].astype(float), np.inf)[0]
        for trace, error in zip(trial_traces, errors, strict=True)
    ])  # fmt: skip
    late = ~np.isfinite(reached)
    outcomes = np.column_stack((reached, np.where(late, merge_near_ties(errors), 0.0)))
    _, place = np.unique(outcomes, axis=0, return_inverse=True)  # in the order of evaluations, then of errors
    return reached, np.asarray(rankdata(-place.ravel()), dtype=np.float64)
