"""The time of trials: wall and processor time, the objective's share, and the signs of a disturbed measurement."""

from __future__ import annotations

import pandas as pd

from bench.analysis.cells import labels

CONTENTION = 1.2  # wall / CPU above this: the trial waited for its core
HIDDEN_THREADS = 1.1  # CPU / wall above this: it used more than one

COLUMNS = (
    "optimizer", "trials", "evaluations_median", "wall_mean", "wall_median", "wall_q1", "wall_q3", "cpu_median",
    "cpu_q1", "cpu_q3", "objective_mean", "objective_share", "speed_median", "speed_q1", "speed_q3",
    "wall_per_cpu", "contention", "hidden_threads",
)  # fmt: skip


def timing(frame: pd.DataFrame) -> pd.DataFrame:
    """Return one row an optimizer over its finished trials on all problems.

    Columns: evaluations_median, those of a trial; wall_mean (thesis Fig. 7.5), and median and quartiles of wall and
    CPU seconds a trial and of evaluations a second (speed); objective_mean, the mean wall seconds inside the problem;
    objective_share, the median share of the wall time spent there; wall_per_cpu, the median ratio; contention and
    hidden_threads, whether that ratio shows that trials waited for a core or used more than one. Assumes one trial a
    core.
    """
    finished = frame[frame["status"] == "ok"]
    rows = []
    for optimizer in labels(frame, "optimizer"):
        own = finished[finished["optimizer"] == optimizer]
        numbers = own[["wall_s", "cpu_s", "objective_s", "nfev"]].astype(float)
        wall, cpu = numbers["wall_s"], numbers["cpu_s"]
        speed = numbers["nfev"] / wall.where(wall > 0)
        ratio = (wall / cpu.where(cpu > 0)).dropna().median()
        rows.append(
            {
                "optimizer": optimizer,
                "trials": len(numbers),
                "evaluations_median": numbers["nfev"].median(),
                "wall_mean": wall.mean(),
                **_spread("wall", wall),
                **_spread("cpu", cpu),
                "objective_mean": numbers["objective_s"].mean(),
                "objective_share": (numbers["objective_s"] / wall.where(wall > 0)).dropna().median(),
                **_spread("speed", speed),
                "wall_per_cpu": ratio,
                "contention": bool(ratio > CONTENTION),
                "hidden_threads": bool(ratio < 1 / HIDDEN_THREADS),
            }
        )
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _spread(name: str, values: pd.Series[float]) -> dict[str, float]:
    q1, median, q3 = values.quantile([0.25, 0.5, 0.75])
    return {f"{name}_median": median, f"{name}_q1": q1, f"{name}_q3": q3}
