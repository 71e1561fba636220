"""Estimate many recordings, also in worker processes, and by the thesis's seeded runs of an optimizer (section 7.3)."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from bench.errors import BenchError
from bench.helpers import printable
from bench.numbers import LARGEST_BUDGET, MOST_TRIALS, require_jobs, require_whole
from bench.optimizer import Optimizer
from bench.seeds import trial_seed
from bench.typing import Floats
from problems.backlash.recordings import Recording
from problems.backlash.sensor.estimate import Estimate, Settings, estimate, infer_gap, infer_peak, signature_problem
from problems.backlash.sensor.workers import FORKS, in_workers
from problems.backlash.signature.model import A
from problems.backlash.signature.problem import FOUND

# Plug-ins are imported where an optimizer runs: an estimate without one does not wait for them.

FEW = 1 if FORKS else 8  # recordings that are estimated before worker processes would have started


@dataclass(frozen=True)
class RunSettings:
    """The settings of an optimizer's runs on a recording: its name and parameters, their number, and their budget.

    Raises:
        BenchError: for an unknown optimizer or parameter, fewer than one run, and a budget below one generation.
    """

    name: str
    options: Mapping[str, Any] = field(default_factory=dict)
    runs: int = 30
    budget: int = 60_000
    seed: int = 0

    def __post_init__(self) -> None:
        require_whole("the trials of an optimizer", self.runs, 1, MOST_TRIALS)
        require_whole("the budget of an optimizer", self.budget, 1, LARGEST_BUDGET)
        self.optimizer().check_budget(self.budget, self.name)

    def optimizer(self) -> Optimizer:
        """Return the optimizer, loaded where it runs: a class from a file cannot be sent to another process."""
        from bench import load_optimizer

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


@dataclass(frozen=True, eq=False)
class Estimated:
    """The estimate of a file, and what an optimizer's runs found in it, where they were asked for."""

    path: Path
    estimate: Estimate
    runs: RepeatedRuns | None = None


@dataclass(frozen=True)
class Failed:
    """A file that could not be estimated, and why, in one sentence."""

    path: Path
    error: str


def estimate_files(
    paths: Sequence[Path],
    read: Callable[[Path], Recording],
    settings: Settings,
    runs: RunSettings | None = None,
    *,
    jobs: int = 1,
) -> Iterator[Estimated | Failed]:
    """Yield the outcome of each file, in their order.

    Args:
        read: returns a file's recording; raises BenchError.
        runs: an optimizer to run on each, too.
        jobs: worker processes; -1 takes every core. The outcomes do not depend on it, but a recording that ends the
            process costs itself only where there are several.

    Raises:
        BenchError: for no worker.
    """
    require_jobs("the number of jobs", jobs)
    work = partial(_estimated, read=read, settings=settings, runs=runs)
    jobs = min(jobs if jobs != -1 else _cores(), len(paths))
    return map(work, paths) if jobs <= 1 or len(paths) <= FEW else in_workers(work, paths, jobs, _lost)


def _cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _estimated(
    path: Path, *, read: Callable[[Path], Recording], settings: Settings, runs: RunSettings | None
) -> Estimated | Failed:
    try:
        with threadpool_limits(limits=1):  # no last digit may depend on how many threads a BLAS finds
            result = estimate(read(path), settings)
            return Estimated(path, result, repeat(result, settings, runs) if runs else None)
    except BenchError as error:
        sentence = str(error)
        return Failed(path, sentence if str(path) in sentence else f"{path}: {sentence}")
    except Exception as error:  # a fault of this program costs no other recording
        line, *_ = str(error).splitlines() or ["no message"]
        reason = printable(f"{type(error).__name__}: {line}", 300)
        return Failed(path, f"{path}: the estimate failed with {reason}")


def _lost(path: Path) -> Failed:
    return Failed(
        path, f"{path}: the process that estimated it ended, such as for want of memory; estimate it alone to see why"
    )


def repeat(estimate: Estimate, settings: Settings, runs: RunSettings) -> RepeatedRuns:
    """Run an optimizer with several seeds on the recording of an estimate that was made with these settings.

    Raises:
        BenchError: where the optimizer fails.
    """
    from bench import solve

    problem = signature_problem(estimate.recording, settings, estimate.period_s)
    optimizer = runs.optimizer()
    results = []
    for number in range(runs.runs):
        seed = trial_seed(runs.seed, problem.name, runs.name, number)
        try:
            results.append(solve(problem, optimizer, budget=runs.budget, seed=seed))
        except BenchError:
            raise
        except Exception as error:  # a plug-in may raise anything
            raise BenchError(f"{runs.name} failed in run {number}: {type(error).__name__}: {error}") from error
    values = np.array([result.fun for result in results])
    sizes = np.array([abs(result.x[A]) for result in results])
    calibration = settings.calibration if estimate.calibration else None  # none where it is of another joint
    gaps = [infer_gap(infer_peak(result.x, calibration), calibration) for result in results]
    hits = int((values <= estimate.rmse_rps * (1 + FOUND)).sum())
    return RepeatedRuns(runs, sizes, np.array(gaps), values, hits)
