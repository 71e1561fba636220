"""Many recordings at once: one that cannot be estimated costs itself only."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from joblib import Parallel, delayed
from threadpoolctl import threadpool_limits

from bench.errors import BenchError
from problems.backlash.recordings import Recording
from problems.backlash.sensor.estimate import Estimate, Settings, estimate
from problems.backlash.sensor.repeated_runs import RepeatedRuns, RunSettings, repeat

FEW = 3
"""So many recordings are estimated before worker processes have started."""


@dataclass(frozen=True, eq=False)
class Estimated:
    """What a file tells.

    Attributes:
        path: the file.
        estimate: the estimate.
        runs: what an optimizer's runs found in it, where some were asked for.
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
    """Yield what becomes of each file, in their order.

    Args:
        paths: the files.
        read: returns a file's recording; raises BenchError.
        settings: how each is estimated.
        runs: an optimizer to run on each besides.
        jobs: worker processes; -1 takes every core. The estimates do not depend on it.

    Raises:
        BenchError: for no worker.
    """
    if jobs == 0:
        raise BenchError("there must be at least one worker process; give --jobs 1 or more, or -1 for every core")
    workers = Parallel(n_jobs=jobs if len(paths) > FEW else 1, return_as="generator")
    made: Iterator[Estimated | Failed] = workers(delayed(_estimated)(path, read, settings, runs) for path in paths)
    return made


def _estimated(
    path: Path, read: Callable[[Path], Recording], settings: Settings, runs: RunSettings | None
) -> Estimated | Failed:
    try:
        with threadpool_limits(limits=1):  # no last digit may depend on how many threads a BLAS finds
            found = estimate(read(path), settings)
            return Estimated(path, found, repeat(found, settings, runs) if runs else None)
    except BenchError as error:
        return Failed(path, _named(path, str(error)))


def _named(path: Path, sentence: str) -> str:
    """Return a sentence that names the file."""
    return sentence if str(path) in sentence else f"{path}: {sentence}"
