"""Open the pool of a backend: this machine, or a dask cluster."""

from __future__ import annotations

from contextlib import AbstractContextManager

from bench.errors import BenchError, nearest
from bench.execution.dask import Cluster, cluster
from bench.execution.local import Local

BACKENDS = ("dask", "local")


def open_pool(backend: str, jobs: int, scheduler: str | None) -> AbstractContextManager[Local | Cluster]:
    """Return a context that yields the pool of a backend: ``jobs`` on this machine, or all workers of a scheduler.

    Raises:
        BenchError: for an unknown backend, a scheduler that is missing or cannot be reached, or workers that differ.
    """
    if backend not in BACKENDS:
        raise BenchError(f"unknown backend {backend!r}{nearest(backend, BACKENDS)}")
    if (backend == "dask") != (scheduler is not None):
        raise BenchError("the dask backend needs --scheduler tcp://HOST:PORT, and no other backend takes one")
    if scheduler is None:
        return Local(jobs)
    return cluster(scheduler)
