"""Estimate many recordings, also in worker processes; report those that cannot be estimated beside the others."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from threadpoolctl import threadpool_limits

from bench.errors import BenchError
from problems.backlash.recordings import Recording
from problems.backlash.sensor.estimate import Estimate, Settings, estimate

if TYPE_CHECKING:
    from problems.backlash.sensor.repeated_runs import RepeatedRuns, RunSettings

FEW = 3
"""Recordings that are estimated before worker processes would have started."""


@dataclass(frozen=True, eq=False)
class Estimated:
    """The estimate of a file.

    Attributes:
        path: the file.
        estimate: the estimate.
        runs: what an optimizer's runs found in it, where they were asked for.
    """

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
        paths: the files.
        read: returns a file's recording; raises BenchError.
        settings: how each is estimated.
        runs: an optimizer to run on each, too.
        jobs: worker processes; -1 takes every core. The estimates do not depend on it.

    Raises:
        BenchError: for no worker.
    """
    if jobs == 0:
        raise BenchError("there must be at least one worker process; give --jobs 1 or more, or -1 for every core")
    if jobs == 1 or len(paths) <= FEW:
        return (_estimated(path, read, settings, runs) for path in paths)
    from joblib import Parallel, delayed

    made: Iterator[Estimated | Failed] = Parallel(n_jobs=jobs, return_as="generator")(
        delayed(_estimated)(path, read, settings, runs) for path in paths
    )
    return made


def _estimated(
    path: Path, read: Callable[[Path], Recording], settings: Settings, runs: RunSettings | None
) -> Estimated | Failed:
    try:
        with threadpool_limits(limits=1):  # no last digit may depend on how many threads a BLAS finds
            found = estimate(read(path), settings)
            if runs is None:
                return Estimated(path, found)
            from problems.backlash.sensor.repeated_runs import repeat

            return Estimated(path, found, repeat(found, settings, runs))
    except BenchError as error:
        sentence = str(error)
        return Failed(path, sentence if str(path) in sentence else f"{path}: {sentence}")
