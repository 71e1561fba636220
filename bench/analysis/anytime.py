"""The search over its evaluations: best-so-far values, targets on the way to the optimum, and the time to reach them.

Every problem has one ladder of targets, the objective values f_L + tau (f_0 - f_L) for falling tau (Moré and Wild
2009, SIAM Journal on Optimization 20); ERT and ECDF derive from its hitting times.
Expected running time and ECDF are those of COCO (Hansen, Auger, Brockhoff, Tušar and Tušar 2016, arXiv:1605.03560).
"""

from __future__ import annotations

from collections.abc import Mapping
from math import prod

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.analysis.cells import Budgets, Traces, labels, spent, traces_of
from bench.contract.objective import Trace
from bench.contract.typing import Floats

Counts = Floats | NDArray[np.int64]  # of evaluations

AT_ONCE = 1_000_000  # hits that are counted at once, to bound memory
CURVE = ("evaluations", "median", "q1", "q3")


def evaluation_grid(budget: int, points: int = 60) -> NDArray[np.int64]:
    """Return increasing evaluation counts from 1 to the budget, spaced evenly on a log axis."""
    return np.unique(np.geomspace(1, budget, points).round().astype(np.int64))


def quartiles(values: Floats) -> Floats:
    """Return median, lower and upper quartile, (3, …, E), of values of n trials, (…, n, E)."""
    shares = [0.5, 0.25, 0.75]
    finite = np.asarray(np.isfinite(values).all(axis=-2, keepdims=True))
    between = np.quantile(np.where(finite, values, 0.0), shares, axis=-2)
    return np.where(finite[..., 0, :], between, np.quantile(values, shares, axis=-2, method="higher"))


def convergence(frame: pd.DataFrame, traces: Traces, evaluations: NDArray[np.int64]) -> pd.DataFrame:
    """Return the best value found so far in every cell: problem, optimizer, evaluations, median, q1 and q3.

    A trial that ended early keeps its last value; a failed one counts as +inf, and so does one without a trace.
    Quartiles are upper order statistics wherever a value is still infinite. No rows for a cell without trials.
    ``evaluations`` are the counts to look at, such as an :func:`evaluation_grid`.
    """
    bests: dict[str, dict[str, list[Floats]]] = {}
    for problem, optimizer, trace in zip(frame["problem"], frame["optimizer"], traces_of(frame, traces), strict=True):
        bests.setdefault(problem, {}).setdefault(optimizer, []).append(trace.at(evaluations))
    tables = []
    order = labels(frame, "optimizer")
    for problem in (label for label in labels(frame, "problem") if label in bests):
        cells = bests[problem]
        optimizers = [label for label in order if label in cells]
        sizes = np.array([len(cells[label]) for label in optimizers])
        curves = np.empty((3, len(optimizers), len(evaluations)))
        for size in set(sizes.tolist()):  # cells of as many trials at once
            alike = np.flatnonzero(sizes == size)
            curves[:, alike] = quartiles(np.array([cells[optimizers[place]] for place in alike]))
        names = {"problem": problem, "optimizer": np.repeat(np.array(optimizers, dtype=object), len(evaluations))}
        along = (np.tile(evaluations, len(optimizers)), *curves.reshape(3, -1))
        tables.append(pd.DataFrame(names | dict(zip(CURVE, along, strict=True))))
    return _stacked(tables, ["problem", "optimizer", *CURVE])


def hitting_times(frame: pd.DataFrame, traces: Traces, targets: pd.DataFrame, budget: Budgets) -> pd.DataFrame:
    """Return one row a trial and target: problem, optimizer, trial, tau, target, evaluations and spent.

    ``evaluations`` is when the trial first reached the target, +inf where it never did. ``spent`` is what the trial
    used in all. A failed trial reached nothing and spent the whole budget, whatever it found before, so that a
    crash is not cheaper than an unsuccessful search. Problem and optimizer stay categories where they are in ``frame``.
    A trial without a trace reached nothing; trials of a problem without ``targets`` have no row. ``budget`` is one
    number, or a number by problem or by (problem, optimizer).
    """
    ladders = {
        problem: rungs[["tau", "target"]].to_numpy(dtype=float).T
        for problem, rungs in targets.groupby("problem", sort=False, observed=True)
    }
    ladder_of = [ladders.get(problem, np.empty((2, 0))) for problem in frame["problem"]]
    sizes = np.array([ladder.shape[1] for ladder in ladder_of], dtype=np.int64)
    rows = np.repeat(np.arange(len(frame), dtype=np.int32), sizes)
    hits = frame[["problem", "optimizer", "trial"]].iloc[rows].reset_index(drop=True)
    reached, ends = np.full(len(rows), np.inf), np.cumsum(sizes)
    for end, (_, target), trace in zip(ends, ladder_of, traces_of(frame, traces), strict=True):
        reached[end - len(target) : end] = _first_reached(trace, target)
    tau, target = np.concatenate([np.empty((2, 0)), *ladder_of], axis=1)
    return hits.assign(tau=tau, target=target, evaluations=reached, spent=spent(frame, budget)[rows])


def expected_running_time(hits: pd.DataFrame) -> pd.DataFrame:
    """Return one row a cell and target: problem, optimizer, tau, target, trials, successes and ert.

    ERT is the sum of the evaluations spent until the target was reached, including those of unsuccessful trials, over
    the number of successes (Hansen et al. 2016): infinite without a success, missing without a trial. It estimates
    the cost of restarts until the first success.
    """
    table = _counts(hits)
    ert = (table["paid"] / table["successes"].where(table["successes"] > 0)).fillna(np.inf)
    return table.drop(columns="paid").assign(ert=ert.where(table["trials"] > 0))


def ecdf(hits: pd.DataFrame, grid: Counts, dimensions: Mapping[str, int] | None = None) -> pd.DataFrame:
    """Return the runtime distribution of each optimizer over all problems: optimizer, evaluations, fraction.

    With ``dimensions``, the d of each problem, the unit is an evaluation a dimension, in which COCO compares problems
    of different dimensions and budgets; the column is then ``per_dimension``.

    ``fraction`` is the mean over problems of the share of all (target, trial) that are reached within that many
    evaluations (Hansen et al. 2016, without simulated restarts). Every problem weighs the same, whatever its trials.
    Compare optimizers only where they have trials on the same problems. Missing for an optimizer without trials.
    """
    tables = []
    unit = "evaluations" if dimensions is None else "per_dimension"
    if dimensions is not None:
        hits = hits.assign(evaluations=hits["evaluations"] / hits["problem"].astype(object).map(dimensions))
    for optimizer in labels(hits, "optimizer"):
        of_optimizer = hits[hits["optimizer"] == optimizer]
        groups = [group for _, group in of_optimizer.groupby("problem", sort=False, observed=True)]
        shares = np.array([_share_within(group["evaluations"], grid) for group in groups]).reshape(-1, len(grid))
        # A plain sum, not a matrix product: its rounding is the same everywhere, so that no curve ever falls.
        fraction = shares.sum(axis=0) / len(groups) if groups else np.nan
        tables.append(pd.DataFrame({"optimizer": optimizer, unit: grid, "fraction": fraction}))
    return _stacked(tables, ["optimizer", unit, "fraction"])


def _first_reached(trace: Trace, ladder: Floats) -> Floats:
    """Return the evaluation at which each target of a falling ladder was first reached, +inf where never."""
    place = np.searchsorted(-trace.values, -ladder)
    return np.append(trace.evaluations, np.inf)[place]


def _counts(hits: pd.DataFrame) -> pd.DataFrame:
    """Return problem, optimizer, tau, target, trials, successes and paid of every cell, also of those without trials.

    ``paid`` is the sum of the evaluations until the target, or of all that were spent where it was not reached.
    """
    problems, optimizers = labels(hits, "problem"), labels(hits, "optimizer")
    taus = pd.Index(hits["tau"].to_numpy(dtype=float)).unique()
    shape = len(problems), len(optimizers), len(taus)
    counts, target = np.zeros((3, prod(shape))), np.full((len(problems), len(taus)), np.nan)
    for start in range(0, len(hits), AT_ONCE):
        part = hits.iloc[start : start + AT_ONCE]
        problem, optimizer = (
            pd.Categorical(part[column], categories=categories).codes.astype(np.intp)
            for column, categories in (("problem", problems), ("optimizer", optimizers))
        )
        rung = taus.get_indexer(pd.Index(part["tau"].to_numpy(dtype=float)))
        cell = (problem * len(optimizers) + optimizer) * len(taus) + rung
        evaluations, spent = (part[column].to_numpy(dtype=float) for column in ("evaluations", "spent"))
        reached = np.isfinite(evaluations)
        for row, weights in zip(counts, (None, reached, np.where(reached, evaluations, spent)), strict=True):
            row += np.bincount(cell, weights, minlength=len(row))
        target[problem, rung] = part["target"]
    trials, successes, sums = counts.reshape(3, *shape)
    on_ladder = trials.any(axis=1, keepdims=True)  # of the problem, whichever optimizer has trials
    at = np.nonzero(np.broadcast_to(on_ladder, shape))
    return pd.DataFrame(
        {
            "problem": np.array(problems, dtype=object)[at[0]],
            "optimizer": np.array(optimizers, dtype=object)[at[1]],
            "tau": taus.to_numpy()[at[2]],
            "target": target[at[0], at[2]],
            "trials": trials[at].astype(int),
            "successes": successes[at].astype(int),
            "paid": sums[at],
        }
    ).astype({"problem": object, "optimizer": object})


def _share_within(times: pd.Series[float], grid: Counts) -> Floats:
    """Return the share of hitting times that are no larger than each value of the grid."""
    return np.searchsorted(np.sort(times.to_numpy()), grid, side="right") / len(times)


def _stacked(tables: list[pd.DataFrame], columns: list[str]) -> pd.DataFrame:
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=columns)
