"""Estimate many recordings, also in worker processes, and by the thesis's seeded runs of an optimizer (section 7.3)."""

import base64
import os
import pickle
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
from problems.backlash.recordings import NoRecordingError, Recording
from problems.backlash.sensor.estimate import Estimate, Settings, estimate, infer_gap, infer_peak
from problems.backlash.signature.model import A
from problems.backlash.signature.problem import FOUND

# Plug-ins are imported where an optimizer runs, and processes where there are many files: others do not wait for them.

FEW = 8  # files that are estimated before worker processes would have started

Joints = Sequence[tuple[str, Callable[[], Recording]]]
"""The joints in a file by name, each with a function that returns its recording or raises BenchError."""


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
    """The estimate of a joint's recording, and what an optimizer's runs found in it, where they were asked for.

    Attributes:
        path: the file.
        estimate: the estimate.
        runs: what the runs found.
        joint: the name of the joint in a file of several, else "".
    """

    path: Path
    estimate: Estimate
    runs: RepeatedRuns | None = None
    joint: str = ""


@dataclass(frozen=True)
class Failed:
    """A recording that could not be estimated.

    Attributes:
        path: the file.
        error: why, in one sentence.
        joint: the name of the joint in a file of several, "" for the whole file.
        stray: whether the file is no recording at all.
    """

    path: Path
    error: str
    joint: str = ""
    stray: bool = False


Outcome = Estimated | Failed


def estimate_files(
    paths: Sequence[Path],
    read: Callable[[Path], Joints],
    settings: Settings,
    runs: RunSettings | None = None,
    *,
    jobs: int = 1,
) -> Iterator[list[Outcome]]:
    """Yield the outcomes of each file, one for each joint in it, in the order of the files.

    Args:
        paths: the files.
        read: returns the joints in a file; a function of a module, or a partial of one. It raises BenchError.
        settings: of every estimate.
        runs: an optimizer to run on each, too.
        jobs: worker processes for more than ``FEW`` files; -1 takes every core. The outcomes do not depend on it, but
            a file that ends a worker process costs itself only.

    Raises:
        BenchError: for no worker.
    """
    require_jobs("the number of jobs", jobs)
    jobs = min(jobs if jobs != -1 else _cores(), len(paths))
    work = partial(_estimated, read=read, settings=settings, runs=runs)
    return map(work, paths) if jobs <= 1 or len(paths) <= FEW else _in_processes(work, paths, jobs)


def _in_processes(work: Callable[[Path], list[Outcome]], paths: Sequence[Path], jobs: int) -> Iterator[list[Outcome]]:
    from bench.sandbox.pool import Pool

    with Pool(jobs, ready) as pool:
        calls = [pool.submit("recordings", pickled, work, path) for path in paths]
        for path, call in zip(paths, calls, strict=True):
            try:
                yield pickle.loads(base64.b64decode(call.result()))
            except RuntimeError as error:  # whatever has ended it
                yield [Failed(path, f"{path}: the process that estimated it ended ({printable(str(error), 100)}), such "
                              "as for want of memory; estimate it alone to see why")]  # fmt: skip


def ready() -> None:
    """Be called first in every process, which has then loaded this module."""


def pickled(work: Callable[[Path], list[Outcome]], path: Path) -> str:
    """Return outcomes as text: answers of processes are JSON."""
    return base64.b64encode(pickle.dumps(work(path))).decode()


def _cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _estimated(
    path: Path, *, read: Callable[[Path], Joints], settings: Settings, runs: RunSettings | None
) -> list[Outcome]:
    try:
        joints = read(path)
    except Exception as error:
        return [_failed(path, "", error)]
    return [_estimated_joint(path, joint, recording, settings, runs) for joint, recording in joints]


def _estimated_joint(
    path: Path, joint: str, recording: Callable[[], Recording], settings: Settings, runs: RunSettings | None
) -> Outcome:
    try:
        with threadpool_limits(limits=1):  # no last digit may depend on how many threads a BLAS finds
            result = estimate(recording(), settings)
            return Estimated(path, result, repeat(result, settings, runs) if runs else None, joint)
    except Exception as error:
        return _failed(path, joint, error)


def _failed(path: Path, joint: str, error: Exception) -> Failed:
    """Return what is told of an error; a fault of this program costs no other recording."""
    sentence = str(error)
    if not isinstance(error, BenchError):
        line, *_ = sentence.splitlines() or ["no message"]
        sentence = f"the estimate failed with {printable(f'{type(error).__name__}: {line}', 300)}"
    if str(path) not in sentence:
        sentence = f"{path}: {sentence}"
    if joint:
        sentence = sentence.replace(str(path), f"{path} ({joint})", 1)
    return Failed(path, sentence, joint, isinstance(error, NoRecordingError))


def repeat(estimate: Estimate, settings: Settings, runs: RunSettings) -> RepeatedRuns:
    """Run an optimizer with several seeds on the recording of an estimate that was made with these settings.

    Raises:
        BenchError: where the optimizer fails.
    """
    from bench import solve

    problem = estimate.problem
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
