"""The best point of each problem, and the run that found it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from bench.analysis.cells import variables


class Best(NamedTuple):
    """The lowest value that any finished trial found on a problem, the first such trial, and its point by variable."""

    problem: str
    value: float
    optimizer: str
    trial: int
    point: dict[str, float]


def best(frame: pd.DataFrame) -> list[Best]:
    """Return the best of each problem on which a finished trial found a finite value, in the order of the frame."""
    values = pd.to_numeric(frame["fun"], errors="coerce").astype(float)
    found = frame.assign(fun=values)[(frame["status"] == "ok") & np.isfinite(values)].reset_index(drop=True)
    rows = found.loc[found.groupby(found["problem"].astype(object), sort=False)["fun"].idxmin()]
    columns = variables(frame)
    names = [name.removeprefix("x_") for name in columns]
    points = (
        {name: float(value) for name, value in zip(names, point, strict=True) if pd.notna(value)}
        for point in rows[columns].itertuples(index=False, name=None)
    )
    keys = rows[["problem", "fun", "optimizer", "trial"]].itertuples(index=False, name=None)
    return [
        Best(str(problem), float(value), str(optimizer), int(trial), point)
        for (problem, value, optimizer, trial), point in zip(keys, points, strict=True)
    ]
