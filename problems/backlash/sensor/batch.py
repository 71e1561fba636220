"""Estimate many recordings, also in worker processes."""

import base64
import pickle
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from threadpoolctl import threadpool_limits

from bench.contract.numbers import require_jobs
from bench.helpers import printable
from bench.helpers.errors import BenchError
from problems.backlash.recordings import NoRecordingError, Recording
from problems.backlash.sensor.estimate import Estimate, Settings, estimate

FEW = 8  # files that are estimated before worker processes would have started

Joints = Sequence[tuple[str, Callable[[], Recording]]]
"""The joints in a file by name, each with a function that returns its recording or raises BenchError."""


@dataclass(frozen=True, eq=False)
class Estimated:
    """The estimate of a joint's recording.

    Attributes:
        path: the file.
        estimate: the estimate.
        joint: the name of the joint in a file of several, else "".
    """

    path: Path
    estimate: Estimate
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
    *,
    n_jobs: int = 1,
) -> Iterator[list[Outcome]]:
    """Yield the outcomes of each file, one for each joint in it, in the order of the files.

    Args:
        paths: the files.
        read: returns the joints in a file; a function of a module, or a partial of one. It raises BenchError.
        settings: of every estimate.
        n_jobs: worker processes for more than ``FEW`` files; -1 takes every core. The outcomes do not depend on it, but
            a file that ends a worker process costs itself only.

    Raises:
        BenchError: for no worker.
    """
    require_jobs("the number of jobs", n_jobs)
    work = partial(_estimated, read=read, settings=settings)
    return map(work, paths) if n_jobs == 1 or len(paths) <= FEW else _in_processes(work, paths, n_jobs)


def _in_processes(work: Callable[[Path], list[Outcome]], paths: Sequence[Path], n_jobs: int) -> Iterator[list[Outcome]]:
    from joblib import effective_n_jobs  # a single file need not wait for it, nor for the processes

    from bench.sandbox.callers import Call, Callers

    with Callers(min(effective_n_jobs(n_jobs), len(paths)), ready) as callers:
        calls = [Call("recordings", pickled, (work, path)) for path in paths]
        for path, (_, answer) in zip(paths, callers.answers(calls), strict=True):
            if isinstance(answer, RuntimeError):  # whatever has ended its process
                yield [Failed(path, f"{path}: the process that estimated it ended ({printable(str(answer), 100)}), "
                              "such as for want of memory; estimate it alone to see why")]  # fmt: skip
            else:
                yield pickle.loads(base64.b64decode(answer))


def ready() -> None:
    """Be called first in every process, which has then loaded this module."""


def pickled(work: Callable[[Path], list[Outcome]], path: Path) -> str:
    """Return outcomes as text: answers of processes are JSON."""
    return base64.b64encode(pickle.dumps(work(path))).decode()


def _estimated(path: Path, *, read: Callable[[Path], Joints], settings: Settings) -> list[Outcome]:
    try:
        joints = read(path)
    except Exception as error:
        return [_failed(path, "", error)]
    return [_estimated_joint(path, joint, recording, settings) for joint, recording in joints]


def _estimated_joint(path: Path, joint: str, recording: Callable[[], Recording], settings: Settings) -> Outcome:
    try:
        with threadpool_limits(limits=1):  # no last digit may depend on how many threads a BLAS finds
            return Estimated(path, estimate(recording(), settings), joint)
    except Exception as error:
        return _failed(path, joint, error)


def _failed(path: Path, joint: str, error: Exception) -> Failed:
    """Return the message of an error; a fault of this program costs no other recording."""
    sentence = str(error)
    if not isinstance(error, BenchError):
        line, *_ = sentence.splitlines() or ["no message"]
        sentence = f"the estimate failed with {printable(f'{type(error).__name__}: {line}', 300)}"
    if str(path) not in sentence:
        sentence = f"{path}: {sentence}"
    if joint:
        sentence = sentence.replace(str(path), f"{path} ({joint})", 1)
    return Failed(path, sentence, joint, isinstance(error, NoRecordingError))
