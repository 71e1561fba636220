"""Expected seconds to a target with several workers: the points of a call of the objective are evaluated at a time.

A call with n points takes ceil(n / p) turns of p workers, each as long as an evaluation. The points of a trial's calls
are taken as equally many: as those of its largest call, where the last call alone may be smaller, as it is where the
budget ends, and else as its evaluations over its calls. The target at evaluation e is reached in the last turn of the
call that holds it, after all calls before it. The optimizer's own time, which no worker shortens, is added in
proportion to the evaluations. So the time to a target is turns times the seconds of an evaluation plus the own time,
and its expectation over restarts that of :func:`bench.analysis.expected_running_time`.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd

from bench.typing import Floats

WORKERS = (1, 2, 4, 8, 16, 32, 64)
SECONDS = (1e-3, 1e-2, 1e-1, 1.0, 10.0, 60.0, 600.0)
"""Workers, and seconds of an evaluation, of the usual tables."""

_CELL = ["problem", "optimizer", "tau", "target"]


def parallel_times(
    hits: pd.DataFrame, frame: pd.DataFrame, workers: Iterable[int] = WORKERS, seconds: Iterable[float] = SECONDS
) -> pd.DataFrame:
    """Return the expected seconds to each target with p workers and evaluations of c seconds, one row a combination.

    Columns: problem, optimizer, tau, target, workers, seconds (of an evaluation), trials, successes, turns (expected)
    and time in seconds, infinite without a success. Cells of which the calls of the objective are not known, as of
    imported trials, have no row.

    Args:
        hits: of :func:`bench.analysis.hitting_times`.
        frame: the trials, with ``nfev``, ``calls``, ``largest_call``, ``wall_s`` and ``objective_s``. A failed trial
            counts with the median batch and own time of its cell.
        workers: numbers of points that are evaluated at a time.
        seconds: of an evaluation.
    """
    workers, seconds = list(workers), np.array(list(seconds), dtype=np.float64)
    batch, own = _of_trials(hits, frame)
    known = np.isfinite(batch)
    rows = hits[known]
    paid = np.minimum(rows["evaluations"].to_numpy(dtype=np.float64), rows["spent"].to_numpy(dtype=np.float64))
    columns = {"own": paid * own[known], "successes": np.isfinite(rows["evaluations"]).astype(int), "trials": 1}
    turns = {p: _turns(paid, batch[known], p) for p in workers}
    keys = [rows[name].astype(object) if name in _CELL[:2] else rows[name] for name in _CELL]
    sums = pd.DataFrame(columns | turns, index=rows.index).groupby(keys, sort=False, observed=True).sum().reset_index()
    successes = sums["successes"].where(sums["successes"] > 0)
    tables = []
    for p in workers:
        expected = (sums[p] / successes).fillna(np.inf).to_numpy()
        idle = (sums["own"] / successes).fillna(np.inf).to_numpy()
        for c in seconds:
            about = {"workers": p, "seconds": c, "turns": expected, "time": c * expected + idle}
            tables.append(sums[[*_CELL, "trials", "successes"]].assign(**about))
    names = [*_CELL, "workers", "seconds", "trials", "successes", "turns", "time"]
    return pd.concat(tables, ignore_index=True)[names] if tables else pd.DataFrame(columns=names)


def parallel_ranks(times: pd.DataFrame) -> pd.DataFrame:
    """Return the mean rank of each optimizer's time over problems and targets, by workers and seconds.

    Columns: workers, seconds, optimizer and rank; the lowest rank is the fastest. Targets that no optimizer reached do
    not count, and where one has no success it is last there. ``times`` are those of :func:`parallel_times`; problems
    that lack one of the optimizers do not count.
    """
    names = ["workers", "seconds", "optimizer", "rank"]
    if times.empty:
        return pd.DataFrame(columns=names)
    wide: pd.DataFrame = times.pivot_table(
        index=["workers", "seconds", "problem", "tau"], columns="optimizer", values="time", sort=False, observed=True
    ).dropna()
    ranks = wide[np.isfinite(wide.to_numpy(dtype=np.float64)).any(axis=1)].rank(axis=1)
    mean = ranks.groupby(level=["workers", "seconds"], sort=False).mean().reset_index()
    table: pd.DataFrame = mean.melt(["workers", "seconds"], var_name="optimizer", value_name="rank")
    return table[names]


def _turns(paid: Floats, batch: Floats, workers: int) -> Floats:
    """Return the turns of ``workers`` in which evaluations are made by calls of ``batch`` points each."""
    calls = np.maximum(np.ceil(paid / batch - 1e-9) - 1, 0)  # before the one that holds the last evaluation
    low = np.floor(batch)
    share = batch - low  # of calls with a point more, where the mean is no whole number
    each = (1 - share) * np.ceil(low / workers) + share * np.ceil((low + 1) / workers)
    return np.asarray(calls * each + np.ceil((paid - calls * batch) / workers - 1e-9))


def _of_trials(hits: pd.DataFrame, frame: pd.DataFrame) -> tuple[Floats, Floats]:
    """Return (hits,) the points of a call, and the optimizer's own seconds for an evaluation, of each hit's trial."""
    names = ("nfev", "calls", "largest_call", "wall_s", "objective_s")
    empty = pd.Series(np.nan, frame.index)
    nfev, calls, largest, wall, objective = (
        pd.to_numeric(frame.get(name, empty), errors="coerce").astype(float).where(frame["status"] == "ok")
        for name in names
    )
    keys = [frame["problem"].astype(object), frame["optimizer"].astype(object)]
    index = pd.MultiIndex.from_arrays([*keys, frame["trial"]])
    wanted = pd.MultiIndex.from_arrays([hits[name].astype(object) for name in ("problem", "optimizer", "trial")])
    places = index.get_indexer(wanted)
    found: list[Floats] = []
    alike = (nfev > (calls - 1) * largest) & (nfev <= calls * largest)
    for values in ((nfev / calls).mask(alike, largest), ((wall - objective) / nfev).clip(lower=0)):
        filled = values.fillna(values.groupby(keys).transform("median"))
        found.append(np.asarray(filled.to_numpy()[places] if len(hits) else [], dtype=np.float64))
    batch, own = found
    return batch, np.nan_to_num(own)
