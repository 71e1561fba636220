"""Open the workers of a backend: loky on this machine, or dask on a cluster."""

from __future__ import annotations

from contextlib import AbstractContextManager

from bench.errors import BenchError, nearest
from bench.execution.pool import Pool

BACKENDS = ("dask", "loky")


def open_pool(backend: str, jobs: int, scheduler: str | None) -> AbstractContextManager[Pool]:
    """Return a context that yields the workers of a backend and ends them.

    Args:
        backend: "loky" or "dask".
        jobs: worker processes of loky; -1 takes every core.
        scheduler: the address of dask's scheduler.

    Raises:
        BenchError: for an unknown backend, a scheduler that is missing or cannot be reached, or workers that differ.
    """
    if backend not in BACKENDS:
        raise BenchError(f"unknown backend {backend!r}{nearest(backend, BACKENDS)}")
    if (backend == "dask") != (scheduler is not None):
        raise BenchError("the dask backend needs --scheduler tcp://HOST:PORT, and no other backend takes one")
    if scheduler is not None:
        from bench.execution.dask import cluster  # needs an extra

        return cluster(scheduler)
    from bench.execution.loky import processes

    return processes(jobs)
