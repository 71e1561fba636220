"""The dask backend, the parent's side: hand trials to the workers of a dask.distributed cluster through joblib.

The workers' side is :mod:`bench.execution.dask_worker`. This module implements joblib's documented interface for
backends and reports batches that fail, are cancelled or lose their scheduler. Joblib's own dask backend does not: it
waits for ever for some of them, and it makes the trials in the parent where the cluster has a single thread.
"""

from __future__ import annotations

import asyncio
import logging
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import closing, contextmanager, suppress
from threading import Event, Thread
from time import monotonic
from typing import Any
from uuid import uuid4

from joblib.parallel import ParallelBackendBase

from bench.errors import BenchError, require
from bench.execution.dask_worker import LOOK, release, work
from bench.execution.pool import Answer, Pool, WorkerDiedError
from bench.execution.supervisor import Task
from bench.storage import provenance
from bench.trial import Trial

CONNECT = 10.0  # seconds for a scheduler to answer
ARRIVE = 20.0  # seconds for the first worker to arrive
RETURN = 600.0  # seconds that a cluster may be without workers before a run gives up
BATCH, LARGEST = 0.5, 100  # limits of a batch: seconds of one thread, and trials
QUEUED = 500  # batches submitted at least, so that workers that join later have work

_LOGGERS = ("distributed", "tornado", "asyncio")


@contextmanager
def cluster(scheduler: str) -> Iterator[Pool]:
    """Yield the workers of a cluster by its scheduler's address; when the context ends, nothing is left on them.

    Raises:
        BenchError: when the extra "dask" is not installed, the scheduler cannot be reached, or it has no workers or
            workers with another version of this package.
    """
    distributed = require("distributed", "dask", "the dask backend needs")
    with _logs_silenced():
        client = _connect(distributed.Client, scheduler)
        try:
            jobs = _wait_for_workers(client, scheduler)
            _refuse_other_versions(client)
            with closing(Cluster(client, scheduler, jobs)) as pool:
                yield pool
        finally:
            with suppress(Exception):
                if client.status == "running":
                    client.run(release, on_error="ignore")
                client.close(timeout=CONNECT)


class Cluster(Pool):
    """The workers of a dask cluster; ``jobs`` is the number of their threads at the start."""

    def __init__(self, client: Any, scheduler: str, jobs: int) -> None:
        from distributed import KilledWorker
        from distributed.comm import CommClosedError

        self._client, self._scheduler = client, scheduler
        self._futures = _Futures(client, jobs)
        super().__init__(jobs, max(3 * jobs, QUEUED), backend=self._futures)
        self.work, self.deaths = work, (KilledWorker,)
        self._losses = (CancelledError, CommClosedError)

    def close(self) -> None:
        """Stop waiting for results."""
        self._futures.close()

    def _map(self, task: Task, trials: Iterable[Trial]) -> Iterator[Answer]:
        ended = Event()
        watch = Thread(target=self._watch, args=(ended,), daemon=True)
        watch.start()
        try:
            yield from super()._map(task, trials)
        except self._losses as error:
            raise self._lost("is gone, or has dropped this run") from error
        except (BenchError, ImportError):  # a worker that joined later
            _refuse_other_versions(self._client)
            raise
        finally:
            ended.set()
            watch.join()

    def _watch(self, ended: Event) -> None:
        """End the run when the scheduler or all workers are lost."""
        seen = monotonic()
        while not ended.wait(LOOK):
            if self._client.status != "running":
                return self._futures.fail(self._lost("is gone"))
            with suppress(Exception):  # a lost scheduler is detected above
                if threads := sum(self._client.nthreads().values()):
                    seen, self._futures.threads = monotonic(), threads
            if monotonic() - seen > RETURN:
                return self._futures.fail(self._lost(f"has had no workers for {RETURN / 60:g} minutes"))
        return None

    def _lost(self, what: str) -> WorkerDiedError:
        return WorkerDiedError(
            f"the scheduler {self._scheduler} {what}; every finished trial is kept: run the same command again to "
            "continue"
        )


class _Futures(ParallelBackendBase):  # type: ignore[misc]
    """Joblib's backend interface, implemented with dask futures."""

    supports_retrieve_callback = True

    def __init__(self, client: Any, jobs: int) -> None:
        super().__init__()
        self._client, self.threads = client, jobs
        self._pending: dict[str, tuple[Any, Callable[[Any], None]]] = {}
        self._callbacks = ThreadPoolExecutor(1)  # joblib's callbacks are slow and must not block the event loop
        self._since, self._made, self._size = monotonic(), 0, 1

    def effective_n_jobs(self, n_jobs: int) -> int:  # noqa: ARG002 - the cluster's own number
        """Return the number of batches made at a time; at least two, as joblib makes a single job's in this process."""
        return max(2, self.threads)

    def submit(self, func: Any, callback: Callable[[Any], None]) -> Any:
        """Submit a batch; the callback is called exactly once, with what the batch returned or raised."""
        key = f"bench-{uuid4().hex}"
        try:
            future = self._client.submit(func, key=key, pure=False)
        except Exception:  # the client was closed meanwhile
            callback(CancelledError())
            return None
        self._pending[key] = future, callback
        self._client.loop.add_callback(self._fetch, key, future)
        return future

    def retrieve_result_callback(self, out: Any) -> Any:
        """Return the batch's results, or raise the exception that ended it."""
        if isinstance(out, BaseException):
            raise out
        return out

    def compute_batch_size(self) -> int:
        """Return the number of trials in a batch."""
        return self._size

    def batch_completed(self, batch_size: int, duration: float) -> None:  # noqa: ARG002 - it is mostly time in a queue
        """Adapt the batch size to half a second of work, from the number of trials made per second."""
        self._made += batch_size
        passed = monotonic() - self._since
        if passed > LOOK:
            self._size = min(max(1, int(BATCH * self._made / (passed * self.threads))), LARGEST)
            self._since, self._made = monotonic(), 0

    def abort_everything(self, ensure_ready: bool = True) -> None:  # noqa: ARG002 - joblib's signature
        """Release all batches; the workers then drop them (:func:`bench.execution.dask_worker.work`)."""
        while self._pending:
            with suppress(KeyError, RuntimeError):
                self._pending.popitem()[1][0].release()

    def fail(self, error: Exception) -> None:
        """Raise an error in whatever waits for a batch."""
        while self._pending:
            with suppress(KeyError, RuntimeError):
                future, callback = self._pending.popitem()[1]
                future.release()
                callback(error)

    def close(self) -> None:
        """End the thread that calls callbacks."""
        self._callbacks.shutdown(wait=False, cancel_futures=True)

    async def _fetch(self, key: str, future: Any) -> None:
        """Wait for one batch, alone: dask makes it again when its worker is lost with the results."""
        out: Any
        try:
            (out,) = await self._client.gather([future], asynchronous=True)
        except Exception as error:
            out = error
        except asyncio.CancelledError:
            out = CancelledError()
        with suppress(RuntimeError):  # closed: nobody waits
            self._callbacks.submit(self._deliver, key, out)

    def _deliver(self, key: str, out: Any) -> None:
        _, callback = self._pending.pop(key, (None, None))
        if callback is not None:
            callback(out)


# checks before the first trial


def _connect(client: Callable[..., Any], scheduler: str) -> Any:
    """Return a client of the scheduler."""
    if not scheduler.strip():
        raise BenchError("the address of the dask scheduler is empty; give one such as tcp://10.0.0.1:8786")
    answer: list[Any] = []

    def connect() -> None:
        try:
            answer.append(client(scheduler, timeout=CONNECT, set_as_default=False))
        except Exception as error:
            answer.append(error)

    # In a thread, since a server that accepts but never answers would block for ever.
    thread = Thread(target=connect, daemon=True)
    with warnings.catch_warnings(action="ignore"):
        thread.start()
        thread.join(CONNECT + LOOK)
    found = answer[0] if answer else TimeoutError()
    if isinstance(found, Exception):
        raise BenchError(
            f"no dask scheduler answers at {scheduler!r} ({type(found).__name__}); start one with 'dask scheduler' and "
            "give the address that it prints, such as tcp://10.0.0.1:8786"
        ) from found
    return found


def _wait_for_workers(client: Any, scheduler: str) -> int:
    """Return the number of threads of all workers."""
    with suppress(TimeoutError):
        client.wait_for_workers(1, timeout=ARRIVE)
    threads = sum(client.nthreads().values())
    if not threads:
        raise BenchError(
            f"the dask cluster at {scheduler} has no workers; start some with 'dask worker {scheduler}' and run the "
            "same command again"
        )
    return int(threads)


def _refuse_other_versions(client: Any) -> None:
    """Raise BenchError where a worker runs another package than this process."""
    own = provenance.package()

    def report_version(dask_worker: Any) -> tuple[str, str]:  # sent as code: the worker may lack this module
        import socket

        try:
            from bench.storage.provenance import package

            runs = package()
        except Exception as error:
            runs = f"no usable backlash-bench ({type(error).__name__}: {error})"
        return f"{dask_worker.name} on {socket.gethostname()}", runs

    found = client.run(report_version, on_error="return").items()
    others = [(who, *answer) for who, answer in found if not isinstance(answer, Exception) and answer[1] != own]
    if others:
        address, name, runs = others[0]
        more = f" ({len(others) - 1} others differ too)" if len(others) > 1 else ""
        raise BenchError(
            f"the worker {address} ({name}) runs {runs}{more}, this process {own}; install the same version on all and "
            "restart them"
        )


@contextmanager
def _logs_silenced() -> Iterator[None]:
    """Silence dask's own log: a run reports errors as sentences."""
    names = [*_LOGGERS, *(each for each in logging.root.manager.loggerDict if each.startswith(_LOGGERS))]
    levels = {logger: logger.level for logger in map(logging.getLogger, names)}
    try:
        for logger in levels:
            logger.setLevel(logging.CRITICAL + 1)
        yield
    finally:
        for logger, level in levels.items():
            logger.setLevel(level)
