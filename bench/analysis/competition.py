"""The table of the CEC competitions: errors of the final values, their tests against one optimizer, and checkpoints.

An error is the best value less the optimum, and 0 from 1e-8 on, as the competitions count it. On a problem whose
optimum is unknown or beaten, the value itself takes its place; ``known`` says which it is.

Sources: the technical reports of the competitions (Awad et al. 2016 for CEC 2017, Yue et al. 2019 for CEC 2020, Kumar
et al. 2021 for CEC 2022), which ask for best, worst, median, mean and standard deviation, and say at which shares of
the budget errors are recorded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import cast

import numpy as np
import pandas as pd

from bench.analysis.cells import Budgets, Traces, budgets, cells, labels, merge_near_ties, quantiles, traces_of
from bench.analysis.direction import ALPHA, effects, inference
from bench.analysis.instances import SOLVED
from bench.contract.typing import Floats

EARLY = (0.01, 0.02, 0.03, 0.05, *(step / 10 for step in range(1, 11)))  # CEC 2014 and 2017
STATISTICS = ("mean", "sd", "median", "best", "worst")


def checkpoint_shares(suite: str, dimension: int) -> tuple[float, ...]:
    """Return the shares of the budget at which a competition records errors; none of other suites.

    14 shares in 2014 and 2017; d^(k/5 - 3) for k = 0 … 15 in 2020 and 2022.
    """
    if suite in ("cec2014", "cec2017"):
        return EARLY
    if suite in ("cec2020", "cec2022") and dimension > 1:
        return tuple(dimension ** (k / 5 - 3) for k in range(16))
    return ()


def error_statistics(frame: pd.DataFrame, optima: Mapping[str, float]) -> pd.DataFrame:
    """Return the final errors of each cell with trials: problem, optimizer, known, trials, failed and the statistics.

    The statistics are mean, sd (n - 1 in the denominator), median, best and worst. A failed trial counts as +inf, so
    that mean and worst of its cell are infinite and the sd is missing; so is that of one trial.
    """
    rows = []
    for (problem, optimizer), values in cells(frame).items():
        if len(values):
            cell = {"problem": problem, "optimizer": optimizer, "known": problem in optima}
            rows.append(cell | _statistics(_errors(values, problem, optima)))
    return pd.DataFrame(rows, columns=["problem", "optimizer", "known", "trials", "failed", *STATISTICS])


def signs(frame: pd.DataFrame, optima: Mapping[str, float], reference: str) -> pd.DataFrame:
    """Return the test of A12 = 0.5 of the reference against each other optimizer: problem, optimizer, p and sign.

    ``sign`` is seen from the reference: ``"+"`` where its errors are lower with p < 0.05, ``"-"`` where they are
    higher, ``"="`` for neither. Each test is at this level by itself; nothing is corrected for their
    number. The test allows that the spreads differ (:mod:`bench.analysis.direction`). Errors that are near-ties are
    ties. A failed trial ends at +inf. Only problems on which both have trials have a row.
    """
    by_cell, rows = cells(frame), []
    for problem in labels(frame, "problem"):
        of_reference = by_cell.get((problem, reference), np.empty(0))
        for optimizer in labels(frame, "optimizer"):
            of_optimizer = by_cell.get((problem, optimizer), np.empty(0))
            if optimizer != reference and len(of_reference) and len(of_optimizer):
                both = merge_near_ties(_errors(np.concatenate((of_reference, of_optimizer)), problem, optima))
                found = effects(both[np.newaxis, : len(of_reference)], both[np.newaxis, len(of_reference) :])
                p, lower = float(inference(found, ALPHA)[2][0]), bool(found.a12[0] > 0.5)
                rows.append((problem, optimizer, p, "=" if p >= ALPHA else "+" if lower else "-"))
    return pd.DataFrame(rows, columns=["problem", "optimizer", "p", "sign"])


def checkpoints(
    frame: pd.DataFrame,
    traces: Traces,
    optima: Mapping[str, float],
    shares: Mapping[str, Sequence[float]],
    budget: Budgets,
) -> pd.DataFrame:
    """Return the errors at shares of the budget: problem, optimizer, share, evaluations, trials, failed, statistics.

    A trial that ended before a checkpoint keeps its last error; before its first value, and where it failed, its error
    is infinite. A checkpoint is at the next evaluation below its share, at least at the first one.

    Args:
        frame: the tidy frame.
        traces: of its trials.
        optima: the optimum by problem; others have no row.
        shares: the shares by problem; others have no row.
        budget: the evaluations that a trial was allowed.
    """
    rows = []
    keys = [frame["problem"].astype(object), frame["optimizer"].astype(object)]
    for key, trials in frame.groupby(keys, sort=False):
        problem, optimizer = map(str, cast("tuple[str, str]", key))
        part = np.asarray(shares.get(problem, ()), dtype=np.float64)
        if problem not in optima or not len(part):
            continue
        spent = np.maximum(np.floor(np.outer(budgets(trials, budget), part) + 1e-9), 1).astype(np.int64)
        values = np.array([trace.at(at) for at, trace in zip(spent, traces_of(trials, traces), strict=True)])
        for share, most, column in zip(part, spent.max(axis=0), values.T, strict=True):
            cell = {"problem": problem, "optimizer": optimizer, "share": share, "evaluations": most}
            rows.append(cell | _statistics(_errors(column, problem, optima)))
    columns = ["problem", "optimizer", "share", "evaluations", "trials", "failed", *STATISTICS]
    return pd.DataFrame(rows, columns=columns)


def _errors(values: Floats, problem: str, optima: Mapping[str, float]) -> Floats:
    if problem not in optima:
        return values
    above = np.asarray(values - optima[problem], dtype=np.float64)
    return np.where(above <= SOLVED, 0.0, above)


def _statistics(errors: Floats) -> dict[str, float]:
    failed = int(np.isposinf(errors).sum())
    spread = float(np.std(errors, ddof=1)) if len(errors) > 1 and not failed else np.nan
    return {"trials": len(errors), "failed": failed, "mean": float(errors.mean()), "sd": spread,
            "median": float(quantiles(errors, 0.5)), "best": float(errors.min()),
            "worst": float(errors.max())}  # fmt: skip
