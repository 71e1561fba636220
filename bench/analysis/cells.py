"""The trials of a study: scores, completeness and summary of each cell (a problem and optimizer), and times.

A failed or non-finite trial scores +inf: it is the worst that can happen, and leaving it out would reward failing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import quantile_test

from bench.contract.objective import Trace
from bench.contract.typing import Floats
from bench.helpers.frames import labels as labels
from bench.study import Study

Traces = Mapping[tuple[str, str, int], Trace]  # by (problem, optimizer, trial); failed trials have none

Budgets = int | Mapping[str, int] | Mapping[tuple[str, str], int]
"""The evaluations of a trial: of all trials, by problem, or by (problem, optimizer)."""

NO_TRACE = Trace(np.empty(0, dtype=np.int64), np.empty(0))
NEAR = 1e-10  # relative: far above rounding, far below any meaningful difference
BEATEN = 1e-9  # relative: an optimum that was computed, to a tolerance, is beaten by more than this or not at all
CONTENTION = 1.2  # wall / CPU above this: the trial waited for its core
HIDDEN_THREADS = 1.1  # CPU / wall above this: it used more than one
CELL = ["problem", "optimizer"]
STATISTICS = ("mean", "sd", "median", "median_low", "median_high", "q1", "q3", "best", "worst")
TIMES = (
    "optimizer", "trials", "evaluations_median", "per_call_median", "wall_mean", "wall_median", "wall_q1", "wall_q3",
    "cpu_median", "cpu_q1", "cpu_q3", "objective_mean", "objective_share", "speed_median", "speed_q1", "speed_q3",
    "own_per_evaluation", "objective_per_evaluation", "memory_most", "wall_per_cpu", "contention", "hidden_threads",
)  # fmt: skip


class ReferenceValue(NamedTuple):
    """The value from which the errors on a problem are counted, and whether it is the problem's ``known`` optimum."""

    value: float
    known: bool


def in_study_order(frame: pd.DataFrame, study: Study) -> pd.DataFrame:
    """Return the tidy frame with ``problem`` and ``optimizer`` as categories of the study, in its order.

    Every function of this package then includes cells without any trial; without categories it cannot know them.
    """
    return frame.assign(
        problem=pd.Categorical(frame["problem"], categories=[entry.label for entry in study.problems]),
        optimizer=pd.Categorical(frame["optimizer"], categories=[entry.label for entry in study.optimizers]),
    )


def budgets(frame: pd.DataFrame, budget: Budgets) -> pd.Series[float]:
    """Return the evaluations that each trial was allowed: one number for all, or by problem, or by cell."""
    if isinstance(budget, Mapping):
        by_cell = any(isinstance(key, tuple) for key in budget)
        keys = list(zip(frame["problem"], frame["optimizer"], strict=True)) if by_cell else frame["problem"]
        return pd.Series(keys, index=frame.index, dtype=object).map(budget).astype(float)
    return pd.Series(float(budget), index=frame.index)


def spent(frame: pd.DataFrame, budget: Budgets) -> Floats:
    """Return the evaluations of each trial, (n,): the whole budget of a failed one, so that a crash is not cheaper."""
    made = pd.to_numeric(frame["nfev"], errors="coerce").astype(float).where(frame["status"] == "ok")
    return np.asarray(made.fillna(budgets(frame, budget)), dtype=np.float64)


def traces_of(frame: pd.DataFrame, traces: Traces) -> Iterator[Trace]:
    """Yield the trace of each trial, an empty one where it failed or has none: its value is +inf throughout."""
    keys = zip(frame["problem"], frame["optimizer"], frame["trial"], strict=True)
    for key, status in zip(keys, frame["status"], strict=True):
        yield traces.get(key, NO_TRACE) if status == "ok" else NO_TRACE


def scores(frame: pd.DataFrame, merge: bool = False) -> pd.Series[float]:
    """Return each trial's objective value as float64, +inf where the trial failed or its value is not finite.

    With ``merge``, near-ties among all scores of a problem become ties (:func:`merge_near_ties`), as in every test
    and rank.
    """
    values = pd.to_numeric(frame["fun"], errors="coerce").astype(float)
    values = values.where((frame["status"] == "ok") & np.isfinite(values), np.inf)
    if not merge:
        return values
    return values.groupby(frame["problem"].astype(object)).transform(lambda group: merge_near_ties(group.to_numpy()))


def variables(trials: pd.DataFrame) -> list[str]:
    """Return the columns ``x_<variable>`` that hold a value for any of the trials, in the frame's order."""
    return [str(name) for name in trials if str(name).startswith("x_") and trials[name].notna().any()]


def stopped_early(frame: pd.DataFrame) -> pd.Series[bool]:
    """Return a flag for each trial: True where a declared criterion ended it, before the budget."""
    stop = frame["stop"]
    return (frame["status"] == "ok") & stop.notna() & ~stop.isin(("budget", "undeclared"))


def merge_near_ties(values: Floats) -> Floats:
    """Return the values with each group of near-ties, equal to a relative 1e-10, replaced by its lowest value.

    Optimizers that find the same optimum differ by rounding, and a test of ranks would test that rounding. Values
    are merged where neighbours in sorted order differ by at most 1e-10 of the larger magnitude; a chain of such
    neighbours becomes one value. Zero, +inf and NaN stay what they are.
    """
    finite = np.isfinite(values)
    distinct, position = np.unique(values[finite], return_inverse=True)
    with np.errstate(over="ignore"):
        apart = np.diff(distinct) > NEAR * np.maximum(np.abs(distinct[1:]), np.abs(distinct[:-1]))
    lowest = np.concatenate((distinct[:1], distinct[1:][apart]))
    group = np.concatenate(([0], apart.cumsum()))
    merged = values.copy()
    merged[finite] = lowest[group[position]]
    return merged


def quantiles(values: Floats, shares: float | Sequence[float]) -> Any:
    """Return quantiles of scores; where one is infinite, upper order statistics, as nothing lies before infinity."""
    return np.quantile(values, shares, method="linear" if np.isfinite(values).all() else "higher")


def cells(frame: pd.DataFrame, merge: bool = False) -> dict[tuple[str, str], Floats]:
    """Return the :func:`scores` of each (problem, optimizer), (n,) in order of trials, empty where there is none."""
    problem, optimizer = frame["problem"].astype(object), frame["optimizer"].astype(object)
    by_cell: dict[object, Floats] = {
        key: np.asarray(values, dtype=np.float64) for key, values in scores(frame, merge).groupby([problem, optimizer])
    }
    return {
        (problem, optimizer): by_cell.get((problem, optimizer), np.empty(0))
        for problem in labels(frame, "problem")
        for optimizer in labels(frame, "optimizer")
    }


def reference_values(
    lowest: Mapping[str, float], optima: Mapping[str, float] | None = None
) -> dict[str, ReferenceValue]:
    """Return the value from which the errors on each problem of ``lowest`` are counted.

    That is the known optimum, or the lowest value that any trial found where no optimum is known or a trial found
    less: a value that is beaten is no optimum. An optimum still counts where the difference is within a relative
    1e-9: it was computed to some tolerance, as the reference fits of signatures are, which trials beat by 2e-10.

    ``lowest`` is the lowest value that any trial of any optimizer found, by problem; +inf where none is finite, which
    is then the reference value of a problem without an optimum.
    """
    return {problem: _reference_value(least, (optima or {}).get(problem, np.inf)) for problem, least in lowest.items()}


def near_best(
    frame: pd.DataFrame, optima: Mapping[str, float], share: float = 0.01, least: float = 1e-8
) -> pd.Series[float]:
    """Return the share of each optimizer's trials that ended near the best known value, the mean over problems.

    Near is within ``share`` of its size, or within ``least`` of it. The best known value is the optimum, or the lowest
    value of all trials (``reference_values``). Only problems on which every optimizer has a trial count; empty
    where there is none.
    """
    values, optimizers = scores(frame), labels(frame, "optimizer")
    problem, optimizer = (frame[name].astype(object) for name in ("problem", "optimizer"))
    lowest = {str(label): float(least_value) for label, least_value in values.groupby(problem).min().items()}
    references = reference_values(lowest, optima)
    best = problem.map({label: reference.value for label, reference in references.items()}).astype(float)
    near = pd.Series(np.isfinite(values) & (values <= best + (share * best.abs()).clip(lower=least)), dtype=float)
    shares = near.groupby([problem, optimizer]).mean().unstack().reindex(columns=optimizers).dropna()
    return shares.mean() if len(shares) else pd.Series(dtype=float)


def regret(table: pd.DataFrame, optima: Mapping[str, float], columns: Sequence[str]) -> pd.DataFrame:
    """Return the rows of the problems of ``optima``, with their optimum subtracted from ``columns``.

    A difference within rounding (a near-tie) becomes 0, and so does one by which an optimum is not beaten
    (``reference_values``). Quantiles carry over: the median regret of trials is the
    regret of their median. ``table`` is a frame with a column problem, such as that of :func:`summarise`.
    """
    rows = table[table["problem"].isin(optima)]
    optimum = rows["problem"].astype(object).map(optima).astype(float)
    above = rows[list(columns)].sub(optimum, axis=0)
    reached = above.le(NEAR * optimum.abs(), axis=0) & above.ge(-BEATEN * optimum.abs(), axis=0)
    return rows.assign(**above.mask(reached, 0.0))


def coverage(frame: pd.DataFrame, planned: int | Mapping[tuple[str, str], int]) -> pd.DataFrame:
    """Return problem, optimizer, stored, failed and missing (of ``planned``) trials of each cell.

    ``planned`` is one number for all cells, or a number by problem and optimizer, 0 where no plan is known.
    """
    every = pd.MultiIndex.from_product([labels(frame, name) for name in CELL], names=CELL)
    lost = pd.Series(np.isinf(scores(frame)), frame.index).groupby([frame[name].astype(object) for name in CELL])
    counts = pd.DataFrame({"stored": lost.size(), "failed": lost.sum()}).reindex(every, fill_value=0).astype(int)
    wanted = planned if isinstance(planned, int) else np.array([planned[cell] for cell in every], dtype=int)
    return counts.assign(missing=np.maximum(wanted - counts["stored"].to_numpy(), 0)).reset_index()


def summarise(frame: pd.DataFrame) -> pd.DataFrame:
    """Return one row a cell: n, failed, mean, sd (n - 1), median, its 95% interval, q1, q3, best and worst.

    ``median_low`` and ``median_high`` are order statistics, so they assume no distribution (Conover 1999, Practical
    Nonparametric Statistics, section 3.2); missing below six trials, which allow no such interval. Mean and sd are
    missing as soon as one trial failed, since no finite number stands for a failure; median and quartiles then are
    the upper order statistics, as nothing lies between a number and infinity.
    """
    rows = [
        {"problem": problem, "optimizer": optimizer, **_describe(values)}
        for (problem, optimizer), values in cells(frame).items()
    ]
    table = pd.DataFrame(rows, columns=["problem", "optimizer", "n", "failed", *STATISTICS])
    return table.astype(dict.fromkeys(STATISTICS, float))


def timing(frame: pd.DataFrame) -> pd.DataFrame:
    """Return one row an optimizer over its finished trials on all problems.

    Columns: evaluations_median, those of a trial; per_call_median, those of a call of the objective, NaN where
    these are unknown; wall_mean (thesis Fig. 7.5), and median and quartiles of wall and CPU seconds a trial and of
    evaluations a second (speed); objective_mean, the mean wall seconds inside the problem; objective_share, the median
    share of the wall time spent there; own_per_evaluation and objective_per_evaluation, the median seconds an
    evaluation outside and inside the problem; memory_most, the most megabytes, as a later trial of a process may use
    what an earlier one has left; wall_per_cpu, the median ratio; contention and hidden_threads, whether that ratio
    shows that trials waited for a core or used more than one. Assumes one trial a core.
    """
    finished = frame[frame["status"] == "ok"]
    rows = []
    for optimizer in labels(frame, "optimizer"):
        of_optimizer = finished[finished["optimizer"] == optimizer]
        numbers = of_optimizer[["wall_s", "cpu_s", "objective_s", "nfev"]].astype(float)
        unknown = pd.Series(np.nan, of_optimizer.index)  # own frames may lack these
        calls, memory = (of_optimizer.get(name, unknown).astype(float) for name in ("calls", "memory_mb"))
        wall, cpu = numbers["wall_s"], numbers["cpu_s"]
        speed = numbers["nfev"] / wall.where(wall > 0)
        ratio = (wall / cpu.where(cpu > 0)).dropna().median()
        rows.append(
            {
                "optimizer": optimizer,
                "trials": len(numbers),
                "evaluations_median": numbers["nfev"].median(),
                "per_call_median": (numbers["nfev"] / calls).dropna().median(),
                "wall_mean": wall.mean(),
                **_spread("wall", wall),
                **_spread("cpu", cpu),
                "objective_mean": numbers["objective_s"].mean(),
                "objective_share": (numbers["objective_s"] / wall.where(wall > 0)).dropna().median(),
                **_spread("speed", speed),
                "own_per_evaluation": ((wall - numbers["objective_s"]) / numbers["nfev"]).median(),
                "objective_per_evaluation": (numbers["objective_s"] / numbers["nfev"]).median(),
                "memory_most": memory.max(),
                "wall_per_cpu": ratio,
                "contention": bool(ratio > CONTENTION),
                "hidden_threads": bool(ratio < 1 / HIDDEN_THREADS),
            }
        )
    return pd.DataFrame(rows, columns=list(TIMES))


def _reference_value(lowest: float, optimum: float) -> ReferenceValue:
    known = bool(np.isfinite(optimum) and lowest >= optimum - BEATEN * abs(optimum))
    return ReferenceValue(float(optimum if known else lowest), known)


def _describe(values: Floats) -> dict[str, float]:
    n, failed = len(values), int(np.isinf(values).sum())
    if n == 0:
        return {"n": 0, "failed": 0}
    q1, median, q3 = quantiles(values, [0.25, 0.5, 0.75])
    places = _median_interval(n)
    low, high = np.sort(values)[list(places)] if places else (np.nan, np.nan)
    return {
        "n": n,
        "failed": failed,
        "mean": values.mean() if not failed else np.nan,
        "sd": _deviation(values) if not failed and n > 1 else np.nan,
        "median": median,
        "median_low": low,
        "median_high": high,
        "q1": q1,
        "q3": q3,
        "best": values.min(),
        "worst": values.max(),
    }


@cache
def _median_interval(n: int) -> tuple[int, int] | None:
    """Return the places, among n sorted values, of the ends of the median's 95% interval; None where it has none."""
    interval: Any = quantile_test(np.arange(n), p=0.5).confidence_interval(0.95)  # depends on n alone
    return None if np.isnan([interval.low, interval.high]).any() else (int(interval.low), int(interval.high))


def _deviation(values: Floats) -> float:
    """Return the standard deviation, also of values whose squares exceed float64."""
    size = float(np.abs(values).max())
    return float((values / size).std(ddof=1) * size) if size else 0.0


def _spread(name: str, values: pd.Series[float]) -> dict[str, float]:
    q1, median, q3 = values.quantile([0.25, 0.5, 0.75])
    return {f"{name}_median": median, f"{name}_q1": q1, f"{name}_q3": q3}
