"""The dask backend, the workers' side: make trials for as long as the parent waits for them."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from threading import Lock, Thread
from time import monotonic, sleep

from bench.execution.job import Task
from bench.execution.supervisor import Supervisor, check
from bench.helpers.errors import BenchError
from bench.storage import provenance
from bench.trial.columns import Row
from bench.trial.trial import Trial

LOOK = 1.0  # seconds between looks at the state of trials
IDLE = 10.0  # seconds after which idle trial processes end

_lock, _checking = Lock(), Lock()
_kept: list[_Kept] = []
_machines: dict[str, str] = {}  # this machine's record, by run


@dataclass(eq=False)
class _Kept:
    """A supervisor, the run that it belongs to, and what states whether it is still needed."""

    run: str
    supervisor: Supervisor
    is_needed: Callable[[], bool]
    is_idle: bool = False


def work(run: str, task: Task, trial: Trial) -> tuple[Row, str]:
    """Make a trial; return its row and the machine's record (JSON).

    Dask cannot interrupt a thread. When the parent has released the trial, was killed or has lost the scheduler, the
    trial's processes are ended from another thread.

    Args:
        run: a unique name of the run, whose trials may share processes.
        task: what all its trials have in common.
        trial: the trial.

    Raises:
        BenchError: when this worker has another version of the package than the parent.
        KilledError: when the parent no longer waits for the trial.
    """
    if (version := provenance.package()) != task.package:
        raise BenchError(f"a worker on {provenance.host()} runs {version}, the run itself {task.package}")
    with _checking:
        machine = _machines.get(run) or _machines.setdefault(run, _machine(task))
    is_wanted = _is_wanted()
    with _lock:
        _start_watch()
        kept = next((each for each in _kept if each.is_idle and each.run == run), None)
        if kept is None:
            _kept.append(kept := _Kept(run, Supervisor(task), is_wanted))
        kept.is_needed, kept.is_idle = is_wanted, False
    row = kept.supervisor.make(trial)
    ended = monotonic()
    with _lock:
        kept.is_needed, kept.is_idle = lambda: monotonic() - ended < IDLE, True
    return row, machine


def _is_wanted() -> Callable[[], bool]:
    """Return a function that states whether the parent waits for the trial that this thread makes."""
    from distributed import get_worker

    worker = get_worker()
    key = worker.get_current_task()

    def is_wanted() -> bool:
        task = worker.state.tasks.get(key)
        return task is not None and task.state == "executing"

    return is_wanted


@cache
def _start_watch() -> None:
    Thread(target=_watch, daemon=True).start()


def _watch() -> None:
    """Kill supervisors that are no longer needed."""
    while True:
        sleep(LOOK)
        with _lock:
            for kept in [each for each in _kept if not each.is_needed()]:
                kept.supervisor.kill()
                _kept.remove(kept)


def _machine(task: Task) -> str:
    """Return this machine's record, with the packages of the study's plug-ins."""
    try:
        return check(task).machine
    except BenchError:  # the trials will fail with the reason
        return json.dumps(provenance.machine())
