"""Running times with their spread: intervals of the ERT, simulated restarts, and times in seconds.

With p the chance of success, ERT = E[time of a success] + (1 - p) / p E[cost of a failure]. Its interval combines those
of the three parts by the method of variance estimates recovery (Zou and Donner 2008, Statistics in Medicine 27): of the
means, Student's; of p, Jeffreys's (Brown, Cai and DasGupta 2001, Statistical Science 16). Where every trial succeeded,
p may still be below 1, and a failure then costs the whole budget; a bootstrap of such trials cannot see this.

A *simulated restart* draws trials of a cell with replacement until a successful one and adds their times (Hansen,
Auger, Ros, Mersmann, Tušar and Brockhoff 2021, Optimization Methods and Software 36, section 4); the mean of such sums
is the ERT. The draws begin with every trial equally often, so that nothing is random where every trial succeeds.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from math import ceil
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.special import betaincinv, stdtrit

from bench.analysis.cells import labels
from bench.analysis.direction import ALPHA, effects, inference, least_p
from bench.analysis.pairwise import holm
from bench.contract.typing import Flags, Floats

RESTARTS = 1000  # simulated restarts a target, as in COCO's tables
SEED = 1
_AT_ONCE, _DRAWN = 2_000_000, 100_000  # simulated restarts that are held in memory, and trials that are drawn for them

Rows = NDArray[np.intp]

SPREAD = ("low", "high", "p10", "p90")


class Batch(NamedTuple):
    """Cells of the same number of trials n and targets T.

    Attributes:
        cells: their problems and optimizers.
        tau: (C, T); target: (C, T).
        paid: (C, n, T), the time until the target, or all that was spent where it was not reached.
        reached: (C, n, T).
        most: (C, T), the most that a trial could have spent.
    """

    cells: list[tuple[str, str]]
    tau: Floats
    target: Floats
    paid: Floats
    reached: Flags
    most: Floats


def running_times(hits: pd.DataFrame, restarts: int = RESTARTS) -> pd.DataFrame:
    """Return the ERT of each cell and target with its spread, one row a cell and target.

    Columns: problem, optimizer, tau, target, trials, successes, ert (as of
    :func:`bench.analysis.expected_running_time`); ``unsuccessful``, the median time that the trials without a success
    spent, missing where there is none; ``low`` and ``high``, its 95% interval; ``p10`` and ``p90``, the
    10th and 90th percentiles of simulated restarts, the dispersion that COCO prints as ratios of the ERT. All four are
    missing without a success; one trial alone has no interval.

    ``hits`` are those of :func:`bench.analysis.hitting_times`, in any unit of time. Their column ``budget`` is what
    each trial was allowed, in that unit: a failure may cost as much where none was seen. Without this column it may
    cost as much as the longest trial on the problem. Cells without trials have no row.
    """
    if "budget" not in hits:
        hits = hits.assign(budget=hits.groupby("problem", observed=True)["spent"].transform("max"))
    tables = []
    for batch in _batches(hits, restarts):
        count, trials, targets = batch.paid.shape
        successes = batch.reached.sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            ert = np.where(successes > 0, batch.paid.sum(axis=1) / successes, np.inf)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # of cells in which every trial succeeded
            unsuccessful = np.nanmedian(np.where(batch.reached, np.nan, batch.paid), axis=1)
        low, high = _intervals(batch)
        drawn = _percentiles(simulated_restarts(batch, restarts), (10, 90))
        p10, p90 = (np.where(np.isfinite(ert), percentile, np.nan) for percentile in drawn)
        problem, optimizer = np.repeat(np.array(batch.cells, dtype=object), targets, axis=0).T
        columns = {
            "tau": batch.tau, "target": batch.target, "trials": np.full((count, targets), trials),
            "successes": successes, "ert": ert, "unsuccessful": unsuccessful,
            "low": low, "high": high, "p10": p10, "p90": p90,
        }  # fmt: skip
        flat = {name: values.ravel() for name, values in columns.items()}
        tables.append(pd.DataFrame({"problem": problem, "optimizer": optimizer} | flat))
    names = ["problem", "optimizer", "tau", "target", "trials", "successes", "ert", "unsuccessful", *SPREAD]
    return _in_order(tables, hits, names)


def separably_fastest(hits: pd.DataFrame) -> pd.DataFrame:
    """Return the targets to which one optimizer is faster than each other one: problem, tau, optimizer and p.

    The one with the lowest ERT is compared with each rival by the test of A12 = 0.5 of the times of trials, an
    unsuccessful one later than any other (:mod:`bench.analysis.direction`). ``p`` is the largest of these, adjusted by
    Holm's method over all problems and targets of ``hits`` that any trial reached; rows have p < 0.05. (COCO's tables
    are corrected for the problems alone.) Which targets any trial reached does not depend on which optimizer made it,
    so that nothing is chosen by the outcome.
    """
    evaluations, spent = (hits[name].to_numpy(dtype=float) for name in ("evaluations", "spent"))
    optimizers = labels(hits, "optimizer")
    owner = pd.Categorical(hits["optimizer"].astype(object), optimizers).codes
    groups: dict[Any, Any] = dict(hits.groupby(["problem", "tau"], sort=False, observed=True).indices)
    reached = {at: rows for at, rows in groups.items() if np.isfinite(evaluations[rows]).any()}
    most = max((int(np.bincount(owner[rows]).max()) for rows in reached.values()), default=0)
    found = []
    if least_p(most) * len(reached) < ALPHA:  # else the trials are too few, whatever the times
        for (problem, tau), rows in sorted(reached.items(), key=lambda group: group[1][0]):
            cells = {place: rows[owner[rows] == place] for place in np.unique(owner[rows])}
            if len(cells) > 1:
                best = min(cells, key=lambda place: _ert(evaluations[cells[place]], spent[cells[place]]))
                rivals = [evaluations[cell] for place, cell in cells.items() if place != best]
                found.append((problem, tau, optimizers[best], _largest_p(evaluations[cells[best]], rivals)))
    table = pd.DataFrame(found, columns=["problem", "tau", "optimizer", "p"])
    table["p"] = holm(table["p"].to_numpy(dtype=float))
    return table[table["p"] < ALPHA].reset_index(drop=True)


def _ert(evaluations: Floats, spent: Floats) -> float:
    """Return the expected running time of a cell, infinite without a success."""
    reached = np.isfinite(evaluations)
    return float(np.where(reached, evaluations, spent).sum()) / reached.sum() if reached.any() else np.inf


def _largest_p(best: Floats, rivals: list[Floats]) -> float:
    """Return the largest p of the tests against rivals, 1 where one is not the slower one more often than not.

    Quantiles are those of Student's t, as Holm's levels are far in the tail: with normal ones a table of 12 problems,
    on which most times are tied, had a star in 6.4% of studies of equals.
    """
    largest = 0.0
    for size in {len(times) for times in rivals}:
        same = np.array([times for times in rivals if len(times) == size])
        found = effects(np.tile(best, (len(same), 1)), same)
        freedom = len(best) + size - 2
        largest = max(largest, float(np.where(found.a12 > 0.5, inference(found, ALPHA, freedom)[2], 1.0).max()))
    return largest


def in_seconds(hits: pd.DataFrame, frame: pd.DataFrame) -> pd.DataFrame:
    """Return hitting times with evaluations, spent and, where it is known, budget in seconds, at each trial's own pace.

    The pace is the trial's wall time over its evaluations; that of a failed trial is the median of its cell. Without a
    recorded time, times are missing.
    """
    nfev, wall = (pd.to_numeric(frame[name], errors="coerce").astype(float) for name in ("nfev", "wall_s"))
    pace = (wall / nfev.where(nfev > 0)).where(frame["status"] == "ok")
    keys = [frame["problem"].astype(object), frame["optimizer"].astype(object)]
    pace = pace.fillna(pace.groupby(keys).transform("median"))
    trial = ["problem", "optimizer", "trial"]
    paces = hits[trial].merge(frame[trial].assign(pace=pace), how="left", on=trial)["pace"].to_numpy()
    times = np.where(np.isfinite(hits["evaluations"]), hits["evaluations"] * paces, np.inf)
    return hits.assign(evaluations=times, **{name: hits[name] * paces for name in ("spent", "budget") if name in hits})


def simulated_restarts(batch: Batch, samples: int, rng: np.random.Generator | None = None) -> Floats:
    """Return (C, T, m) times of simulated restarts, infinite where no trial succeeded.

    m is the least multiple of the number of trials that is not below ``samples``.
    """
    rng = np.random.default_rng(SEED) if rng is None else rng
    count, trials, targets = batch.paid.shape
    first = np.tile(np.arange(trials), ceil(samples / trials))
    paid, reached = batch.paid.transpose(0, 2, 1), batch.reached.transpose(0, 2, 1)  # (C, T, n)
    drawn = paid[:, :, first]
    possible: Flags = np.asarray(reached.any(axis=2))
    drawn[~possible] = np.inf
    waiting = np.flatnonzero((~reached[:, :, first] & possible[:, :, np.newaxis]).ravel())
    flat, times, ends = drawn.reshape(-1), paid.flatten(), reached.flatten()
    while len(waiting):
        left = []
        for part in np.split(waiting, range(_DRAWN, len(waiting), _DRAWN)):
            at = part // len(first) * trials + rng.integers(0, trials, len(part))
            flat[part] += times[at]
            left.append(part[~ends[at]])
        waiting = np.concatenate(left)
    return flat.reshape(count, targets, len(first))


def _intervals(batch: Batch) -> tuple[Floats, Floats]:
    """Return the (C, T) ends of the 95% intervals of the ERT."""
    trials, reached, most = batch.paid.shape[1], batch.reached, batch.most
    successes = reached.sum(axis=1).astype(float)
    failures = trials - successes
    with np.errstate(divide="ignore", invalid="ignore"):
        odds = failures / successes
        least, greatest = (1 / betaincinv(successes + 0.5, failures + 0.5, share) - 1 for share in (0.975, 0.025))
        least = np.where(failures == 0, 0.0, least)
        time, time_low, time_high = _mean(batch.paid, reached, most)
        cost, cost_low, cost_high = _mean(batch.paid, ~reached, most)
        ert = time + odds * cost
        low = ert - np.sqrt((time - time_low) ** 2 + ((odds - least) * cost) ** 2 + (odds * (cost - cost_low)) ** 2)
        high = ert + np.sqrt(
            (time_high - time) ** 2 + ((greatest - odds) * cost) ** 2 + (odds * (cost_high - cost)) ** 2
        )
    missing = (successes == 0) | (trials == 1)
    return np.where(missing, np.nan, np.maximum(low, 0.0)), np.where(missing, np.nan, high)


def _mean(paid: Floats, chosen: Flags, most: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the (C, T) mean of the ``chosen`` ones of the (C, n, T) times, and the ends of its 95% interval.

    The interval is Student's within 0 and the ``most``; that is all that is known from a single time. Without any, the
    ``most`` is the mean.
    """
    count = chosen.sum(axis=1).astype(float)
    mean = np.where(chosen, paid, 0.0).sum(axis=1) / count
    deviations = np.where(chosen, paid - mean[:, np.newaxis], 0.0)
    error = np.sqrt((deviations**2).sum(axis=1) / (count - 1) / count) * stdtrit(count - 1, 0.975)
    several = count > 1
    low = np.where(several, np.maximum(mean - error, 0.0), 0.0)
    high = np.where(several, np.minimum(mean + error, most), most)
    none = count == 0
    return np.where(none, most, mean), np.where(none, most, low), np.where(none, most, high)


def _percentiles(drawn: Floats, shares: tuple[float, ...]) -> list[Floats]:
    """Sort the last axis and return its percentiles, missing where infinite; between order statistics as cocopp's."""
    percentiles = []
    drawn.sort(axis=-1)
    size = drawn.shape[-1]
    for share in shares:
        place = min(max(share / 100 * size - 0.5, 0.0), size - 1.0)
        low = int(place)
        high = min(low + 1, size - 1)
        with np.errstate(invalid="ignore"):
            value = (low + 1 - place) * drawn[..., low] + (place - low) * drawn[..., high]
        percentiles.append(np.where(np.isfinite(value), value, np.nan))
    return percentiles


def _batches(hits: pd.DataFrame, numbers: int) -> Iterator[Batch]:
    """Yield the cells that have trials, those of one shape together; ``each`` numbers a target are held in memory."""
    groups: dict[Any, Any] = dict(hits.groupby(["problem", "optimizer"], sort=False, observed=True).indices)
    tau, target, evaluations, spent, budget = (
        hits[name].to_numpy(dtype=float)
        for name in ("tau", "target", "evaluations", "spent", "budget" if "budget" in hits else "spent")
    )
    trial = hits["trial"].to_numpy()
    alike: dict[tuple[int, int], list[tuple[tuple[str, str], Rows]]] = {}
    for (problem, optimizer), rows in groups.items():
        ordered = rows[np.argsort(trial[rows], kind="stable")]
        targets = int(np.count_nonzero(trial[rows] == trial[rows[0]]))
        alike.setdefault((len(rows) // targets, targets), []).append(((str(problem), str(optimizer)), ordered))
    for (trials, targets), cells in alike.items():
        at_once = max(_AT_ONCE // (targets * max(numbers, trials)), 1)
        for start in range(0, len(cells), at_once):
            names, rows_of = zip(*cells[start : start + at_once], strict=True)
            rows = np.array(rows_of).reshape(len(names), trials, targets)
            reached = ~np.isposinf(evaluations[rows])  # a missing time is that of a success at an unknown time
            paid = np.where(reached, evaluations[rows], spent[rows])
            most = np.maximum(spent[rows], budget[rows]).max(axis=1)
            yield Batch(list(names), tau[rows[:, 0]], target[rows[:, 0]], paid, reached, most)


def _in_order(tables: list[pd.DataFrame], hits: pd.DataFrame, columns: list[str]) -> pd.DataFrame:
    """Return the tables as one, cells in the order of the study, and targets as they are."""
    if not tables:
        return pd.DataFrame(columns=columns)
    table = pd.concat(tables, ignore_index=True)
    place = [pd.Categorical(table[name], categories=labels(hits, name)).codes for name in ("problem", "optimizer")]
    order = np.lexsort((np.arange(len(table)), place[1], place[0]))
    return table.iloc[order].reset_index(drop=True)[columns]
