"""The dask backend, the workers' side: make trials for as long as the parent waits for them."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import cache
from threading import Lock, Thread
from time import monotonic, sleep

from bench.errors import BenchError
from bench.execution.job import Task
from bench.execution.supervisor import Supervisor, check
from bench.storage import provenance
from bench.trial import Row, Trial

LOOK = 1.0  # seconds between looks at the state of batches
IDLE = 60.0  # seconds after which idle trial processes end

_lock, _checking = Lock(), Lock()
_wanted: dict[Supervisor, Callable[[], bool]] = {}  # with what states whether a supervisor is still needed
_idle: dict[Supervisor, str] = {}  # those of them that wait for a batch, with their run
_ended: set[str] = set()  # runs
_machines: dict[str, str] = {}  # this machine's record, by run


def work(run: str, task: Task, trials: Sequence[Trial]) -> tuple[list[tuple[Trial, Row]], str, float]:
    """Make a batch of trials; return them with their rows, the machine's record (JSON), and the seconds that they took.

    Dask cannot interrupt a thread. When the parent has released the batch, was killed or has lost the scheduler, the
    trial processes are ended from another thread.

    Args:
        run: a unique name of the run, whose batches may share trial processes.
        task: what all its trials have in common.
        trials: the batch.

    Raises:
        BenchError: when this worker has another version of the package than the parent.
        KilledError: when the parent no longer waits for the batch.
    """
    version = provenance.package()
    if version != task.package:
        raise BenchError(
            f"a worker on {provenance.host()} runs {version}, the run itself {task.package}; install the same version "
            "on both"
        )
    with _checking:
        if run not in _machines:
            _machines[run] = _machine(task)
        machine = _machines[run]
    began = monotonic()
    is_wanted = _is_wanted()
    with _lock:
        _start_watch()
        supervisor = next((idle for idle, its_run in _idle.items() if its_run == run), None) or Supervisor(task)
        _idle.pop(supervisor, None)
        _wanted[supervisor] = is_wanted
    made = [(trial, supervisor.make(trial)) for trial in trials]
    ended = monotonic()
    with _lock:
        if supervisor in _wanted and is_wanted():
            _idle[supervisor] = run
            _wanted[supervisor] = lambda: run not in _ended and monotonic() - ended < IDLE
    return made, machine, ended - began


def end(run: str) -> None:
    """End the idle trial processes of a run."""
    _ended.add(run)


def _is_wanted() -> Callable[[], bool]:
    """Return a function that states whether the parent waits for the batch that this thread makes."""
    from distributed import get_worker

    worker = get_worker()
    key = worker.get_current_task()

    def is_wanted() -> bool:
        batch = worker.state.tasks.get(key)
        return batch is not None and batch.state == "executing"

    return is_wanted


@cache
def _start_watch() -> None:
    Thread(target=_watch, daemon=True).start()


def _watch() -> None:
    """Kill supervisors that are no longer needed."""
    while True:
        sleep(LOOK)
        with _lock:
            for supervisor in [begun for begun, is_wanted in _wanted.items() if not is_wanted()]:
                supervisor.kill()
                _idle.pop(supervisor, None)
                del _wanted[supervisor]


def _machine(task: Task) -> str:
    """Return this machine's record, with the packages of the study's plug-ins."""
    try:
        return check(task).machine
    except BenchError:  # the trials will fail with the reason
        return json.dumps(provenance.machine())
