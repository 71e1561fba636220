"""The dask backend, the parent's side: have the workers of a dask.distributed cluster make trials.

The workers' side is :mod:`bench.execution.dask_worker`.
"""

from __future__ import annotations

import asyncio
import logging
import warnings
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import CancelledError
from contextlib import closing, contextmanager, suppress
from functools import partial
from itertools import islice
from queue import Empty, SimpleQueue
from threading import Thread
from time import monotonic
from typing import Any
from uuid import uuid4

from bench.execution.dask_worker import LOOK, work
from bench.execution.job import Task
from bench.execution.local import Answer, Missing, OnBegin
from bench.execution.supervisor import KilledError, Loaded, WorkerDiedError, check
from bench.helpers.errors import BenchError, require
from bench.storage import provenance
from bench.trial.trial import Trial

CONNECT = 10.0  # seconds for a scheduler to answer
ARRIVE = 20.0  # seconds for the first worker to arrive
RETURN = 600.0  # seconds that a cluster may be without workers before a run gives up
DEATHS = 3  # of trials that dask gives up, without a finished one between them, before a run gives up
QUEUED = 500  # trials submitted at least, so that workers that join later have work

_LOGGERS = ("distributed", "tornado", "asyncio")


@contextmanager
def cluster(scheduler: str) -> Iterator[Cluster]:
    """Yield the workers of a cluster by its scheduler's address.

    Raises:
        BenchError: when the extra "dask" is not installed, the scheduler cannot be reached, or it has no workers or
            workers with another version of this package.
    """
    distributed = require("distributed", "dask", "the dask backend needs")
    with _logs_silenced():
        client = _connect(distributed.Client, scheduler)
        try:
            with suppress(TimeoutError):
                client.wait_for_workers(1, timeout=ARRIVE)
            if not (threads := sum(client.nthreads().values())):
                raise BenchError(
                    f"the dask cluster at {scheduler} has no workers; start some with 'dask worker {scheduler}' and "
                    "run the same command again"
                )
            _refuse_other_versions(client)
            yield Cluster(client, scheduler, threads)
        finally:
            with suppress(Exception):
                client.close(timeout=CONNECT)


class Cluster:
    """The workers of a cluster, used as :class:`bench.execution.local.Local` is; they began with ``jobs`` threads."""

    _task: Task  # what was loaded

    def __init__(self, client: Any, scheduler: str, jobs: int) -> None:
        self._client, self._scheduler, self.jobs = client, scheduler, jobs
        self._queued = max(3 * jobs, QUEUED)
        self._seen = monotonic()  # when the cluster had workers
        self._next_look = 0.0

    def load(self, task: Task, *, shared: bool = False) -> Loaded:
        """Load all plug-ins of a study in this machine; the workers have limits of memory of their own."""
        del shared
        self._task = task
        return check(task)

    def answers(self, on_begin: OnBegin | None, missing: Missing) -> Iterator[Answer]:
        """Yield answers; see :meth:`bench.execution.local.Local.answers`.

        A lost worker costs only time: dask begins its trials again elsewhere. When dask gives a trial up, having lost
        several workers with it, all missing trials are submitted again.
        """
        from distributed import KilledWorker
        from distributed.comm import CommClosedError

        del on_begin  # the workers do not say what they begin
        deaths = 0
        while True:
            try:
                with closing(self._made(iter(missing()))) as made:
                    for answer in made:
                        deaths = 0
                        yield answer
                return
            except (KilledWorker, KilledError) as error:
                deaths += 1
                if deaths == DEATHS:
                    raise WorkerDiedError(
                        f"{DEATHS} worker processes in a row were killed before they had made a trial (is the machine "
                        "short of memory?); every finished trial is kept: run the same command again to continue"
                    ) from error
            except (CancelledError, asyncio.CancelledError, CommClosedError) as error:
                raise self._lost("is gone, or has dropped this run") from error
            except WorkerDiedError:
                raise
            except Exception:  # anything may come from a worker that joined later with other code
                _refuse_other_versions(self._client)
                raise

    def _made(self, trials: Iterator[Trial]) -> Generator[Answer]:
        """Yield answers until there are no more trials; raise the first error of a worker."""
        client, name, pending = self._client, uuid4().hex, dict[Any, Trial]()
        ended: SimpleQueue[Any] = SimpleQueue()
        try:
            while True:
                for trial in islice(trials, max(0, self._queued - len(pending))):
                    future = client.submit(work, name, self._task, trial, key=f"bench-{uuid4().hex}", pure=False)
                    pending[future] = trial
                    future.add_done_callback(ended.put)
                if not pending:
                    return
                self._look()
                with suppress(Empty):
                    future = ended.get(timeout=LOOK)
                    try:
                        answer = future.result(timeout=LOOK)
                    except TimeoutError:  # its worker was lost before it was fetched, so it is made again
                        ended.put(future)
                    else:
                        yield pending.pop(future), *answer
        finally:
            for future in pending:
                future.release()  # its worker then ends the trial's processes

    def _look(self) -> None:
        """Raise WorkerDiedError when the scheduler is lost, or all workers have been for long."""
        if self._client.status != "running":
            raise self._lost("is gone")
        if monotonic() < self._next_look:
            return
        with suppress(Exception):  # of a scheduler that is lost just now
            if threads := sum(self._client.nthreads().values()):
                self._seen, self._queued = monotonic(), max(3 * threads, QUEUED)
        if monotonic() - self._seen > RETURN:
            raise self._lost(f"has had no workers for {RETURN / 60:g} minutes")
        self._next_look = monotonic() + LOOK

    def _lost(self, what: str) -> WorkerDiedError:
        return WorkerDiedError(
            f"the scheduler {self._scheduler} {what}; every finished trial is kept: run the same command again to "
            "continue"
        )


def _connect(client: Callable[..., Any], scheduler: str) -> Any:
    """Return a client of the scheduler."""
    if not scheduler.strip():
        raise BenchError("the address of the dask scheduler is empty; give one such as tcp://10.0.0.1:8786")
    answer: SimpleQueue[object] = SimpleQueue()
    asked = partial(client, scheduler, timeout=CONNECT, set_as_default=False)

    def connect() -> None:
        try:
            try:
                answer.put(asked())
            except AssertionError:  # of dask's own, where a busy scheduler sends its first two messages as one
                answer.put(asked())
        except Exception as error:
            answer.put(error)

    with warnings.catch_warnings(action="ignore"):
        # In a thread, since a server that accepts but never answers would block for ever.
        Thread(target=connect, daemon=True).start()
        try:
            connected = answer.get(timeout=CONNECT + LOOK)
        except Empty:
            connected = TimeoutError()
    if isinstance(connected, Exception):
        raise BenchError(
            f"no dask scheduler answers at {scheduler!r} ({type(connected).__name__}); start one with 'dask scheduler' "
            "and give the address that it prints, such as tcp://10.0.0.1:8786"
        ) from connected
    return connected


def _refuse_other_versions(client: Any) -> None:
    """Raise BenchError where a worker runs another package than this process."""
    version = provenance.package()

    def report_version(dask_worker: Any) -> tuple[str, str]:  # sent as code: the worker may lack this module
        import socket

        try:
            from bench.storage.provenance import package

            runs = package()
        except Exception as error:
            runs = f"no usable backlash-bench ({type(error).__name__}: {error})"
        return f"{dask_worker.name} on {socket.gethostname()}", runs

    versions = client.run(report_version, on_error="ignore").items()
    different = [(address, name, runs) for address, (name, runs) in versions if runs != version]
    if different:
        address, name, runs = different[0]
        more = f" ({len(different) - 1} others differ too)" if len(different) > 1 else ""
        raise BenchError(
            f"the worker {address} ({name}) runs {runs}{more}, this process {version}; install the same version on all "
            "and restart them"
        )


@contextmanager
def _logs_silenced() -> Iterator[None]:
    """Silence dask's own log: a run reports errors as sentences."""
    names = [*_LOGGERS, *(name for name in logging.root.manager.loggerDict if name.startswith(_LOGGERS))]
    levels = {logger: logger.level for logger in map(logging.getLogger, names)}
    try:
        for logger in levels:
            logger.setLevel(logging.CRITICAL + 1)
        yield
    finally:
        for logger, level in levels.items():
            logger.setLevel(level)
