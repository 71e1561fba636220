"""An estimate the thesis's way (sections 7.3 and 8.3): many seeded runs of an optimizer, their mean and deviation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bench.errors import BenchError
from bench.execution.solve import solve
from bench.numbers import require_whole
from bench.optimizer import Optimizer
from bench.plugins.loading import load_optimizer
from bench.problem import Floats
from bench.seeds import trial_seed
from problems.backlash.sensor.estimate import Estimate, Settings, infer_gap, infer_peak, signature_problem
from problems.backlash.signature.model import A
from problems.backlash.signature.problem import FOUND


@dataclass(frozen=True)
class RunSettings:
    """Which optimizer is run on a recording, how often, and how long.

    Attributes:
        name: the optimizer's name, by which it is loaded.
        options: its parameters.
        runs: how many runs.
        budget: evaluations of each.
        seed: the root of the runs' seeds.

    Raises:
        BenchError: for an unknown optimizer or parameter, less than one run, and a budget below one generation.
    """

    name: str
    options: Mapping[str, Any] = field(default_factory=dict)
    runs: int = 30
    budget: int = 60_000
    seed: int = 0

    def __post_init__(self) -> None:
        require_whole("the runs of an optimizer", self.runs, 1)
        self.optimizer().check_budget(self.budget, self.name)

    def optimizer(self) -> Optimizer:
        """Return the optimizer, loaded where it is run: a class from a file cannot be sent to another process."""
        return load_optimizer(self.name, **self.options)


@dataclass(frozen=True, eq=False)
class RepeatedRuns:
    """What the runs of an optimizer found.

    Attributes:
        settings: what was run.
        sizes_rps: (runs,) |A| of their fits.
        backlashes_rad: (runs,) the half-gaps that these tell of, NaN where the calibration does not reach.
        values_rps: (runs,) RMSEs.
        found: in how many runs the reference fit was found.
    """

    settings: RunSettings
    sizes_rps: Floats
    backlashes_rad: Floats
    values_rps: Floats
    found: int


def repeat(estimate: Estimate, settings: Settings, runs: RunSettings) -> RepeatedRuns:
    """Return what seeded runs of an optimizer find in the recording of an estimate that was made by these settings.

    Raises:
        BenchError: where the optimizer fails.
    """
    problem = signature_problem(estimate.recording, settings, estimate.period_s)
    optimizer = runs.optimizer()
    points, values = [], []
    for number in range(runs.runs):
        seed = trial_seed(runs.seed, problem.name, runs.name, number)
        try:
            result = solve(problem, optimizer, budget=runs.budget, seed=seed)
        except BenchError:
            raise
        except Exception as error:  # a plug-in may raise anything
            raise BenchError(f"{runs.name} failed in run {number}: {type(error).__name__}: {error}") from error
        points.append(result.x)
        values.append(result.fun)
    sizes = np.abs(np.array(points)[:, A])
    gaps = [infer_gap(infer_peak(x, settings.calibration), settings.calibration) for x in points]
    found = sum(value <= estimate.rmse_rps * (1 + FOUND) for value in values)
    return RepeatedRuns(runs, sizes, np.array(gaps), np.array(values), found)
