"""Count the values of optimizers that cannot reach a problem's optimum from the best value that they can reach."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

import pandas as pd

from bench.analysis.cells import BEATEN, Traces, scores
from bench.contract.objective import Trace

Shifts = Mapping[tuple[str, str], float]
"""By problem and optimizer, how much the best value that the optimizer can reach is above the problem's optimum."""


def shifts(
    frame: pd.DataFrame, optima: Mapping[str, float], repaired: Mapping[str, float], repairing: Collection[str]
) -> Shifts:
    """Return the shifts of the cells of optimizers that repair their points, where these cannot reach the optimum.

    An optimizer that ended below the optimum of repaired points on any problem does not repair, and has no shift.

    Args:
        frame: the tidy frame.
        optima: the optimum by problem.
        repaired: the optimum of repaired points by problem.
        repairing: the optimizers that are taken to repair their points.
    """
    keys = [frame[name].astype(object) for name in ("problem", "optimizer")]
    limit = keys[0].map(repaired).astype(float)
    below = set(keys[1][scores(frame) < limit - BEATEN * limit.abs()])
    return {
        (problem, optimizer): repaired[problem] - optima[problem]
        for problem, optimizer in dict.fromkeys(zip(*keys, strict=True))
        if problem in repaired and problem in optima and optimizer in repairing and optimizer not in below
    }


def shifted(frame: pd.DataFrame, by: Shifts) -> pd.DataFrame:
    """Return the frame with the values of the cells of ``by`` lowered, so that regret counts from the optimum."""
    if not by:
        return frame
    keys = zip(frame["problem"], frame["optimizer"], strict=True)
    lower = pd.Series([by.get(key, 0.0) for key in keys], index=frame.index)
    return frame.assign(fun=pd.to_numeric(frame["fun"], errors="coerce").astype(float) - lower)


@dataclass(frozen=True)
class ShiftedTraces(Mapping[tuple[str, str, int], Trace]):
    """Traces with the values of the cells of ``by`` lowered likewise."""

    traces: Traces
    by: Shifts

    def __getitem__(self, key: tuple[str, str, int]) -> Trace:
        trace, lower = self.traces[key], self.by.get(key[:2])
        return trace if lower is None else Trace(trace.evaluations, trace.values - lower)

    def __iter__(self) -> Iterator[tuple[str, str, int]]:
        return iter(self.traces)

    def __len__(self) -> int:
        return len(self.traces)
