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
    names = {column: column.removeprefix("x_") for column in variables(frame)}
    return [
        Best(
            str(row["problem"]), float(row["fun"]), str(row["optimizer"]), int(row["trial"]),
            {name: float(row[column]) for column, name in names.items() if pd.notna(row[column])},
        )
        for row in rows.to_dict("records")
    ]  # fmt: skip
