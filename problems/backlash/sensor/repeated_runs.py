"""Estimate as the thesis does (sections 7.3 and 8.3): by many seeded runs of an optimizer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bench.errors import BenchError
from bench.numbers import require_whole
from bench.optimizer import Optimizer
from bench.plugins.loading import load_optimizer
from bench.problem import Floats
from bench.seeds import trial_seed
from bench.trial import solve
from problems.backlash.sensor.estimate import Estimate, Settings, infer_gap, infer_peak, signature_problem
from problems.backlash.signature.model import A
from problems.backlash.signature.problem import FOUND


@dataclass(frozen=True)
class RunSettings:
    """The settings of an optimizer's runs on a recording: which optimizer, how often, and how long.

    Attributes:
        name: the name that the optimizer is loaded by.
        options: its parameters.
        runs: the number of runs.
        budget: evaluations of each run.
        seed: the root of the runs' seeds.

    Raises:
        BenchError: for an unknown optimizer or parameter, fewer than one run, and a budget below one generation.
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
        """Return the optimizer, loaded where it runs: a class from a file cannot be sent to another process."""
        return load_optimizer(self.name, **self.options)


@dataclass(frozen=True, eq=False)
class RepeatedRuns:
    """The results of an optimizer's runs on a recording.

    Attributes:
        settings: the settings of the runs.
        sizes_rps: (runs,) |A| of their fits.
        backlashes_rad: (runs,) the half-gaps inferred from them, NaN outside the calibration.
        values_rps: (runs,) RMSEs of their fits.
        found: how many runs found the reference fit.
    """

    settings: RunSettings
    sizes_rps: Floats
    backlashes_rad: Floats
    values_rps: Floats
    found: int


def repeat(estimate: Estimate, settings: Settings, runs: RunSettings) -> RepeatedRuns:
    """Run an optimizer with several seeds on the recording of an estimate that was made with these settings.

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
