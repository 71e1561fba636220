"""Share the open files that this process may have among the jobs of a run."""

from __future__ import annotations

import sys
from contextlib import suppress

import psutil

from bench.errors import BenchError
from bench.plugins import loading
from bench.study import Study

try:
    import resource
except ImportError:  # on Windows, which counts no sockets
    resource = None  # type: ignore[assignment]

KEPT = 64  # warmed-up optimizers of a job at most; more are warmed up again when their turn comes
FILES = 2  # that each process of a job takes: the channel to it, and its output
PASSING = 12  # that a job has open for a moment, while it starts a process
RESERVE = 64  # for all else: the store, figures, modules that are imported


def kept(study: Study, jobs: int) -> int:
    """Return how many warmed-up optimizers each job may keep, as many as the open files of this process allow.

    The soft limit of open files is raised where that helps; only where the hard one is reached, fewer are kept.

    Raises:
        BenchError: where even one for each job would be too many.
    """
    families = {loading.family(entry.name) for entry in study.problems}
    most = min(KEPT, len(families) * len(study.optimizers))
    # Of a job: the first ones, and for each family those of its problems and of each package.
    always = 2 + len(families) * (1 + len(study.packages()))

    def needed(jobs: int, kept: int) -> int:
        return _open() + RESERVE + jobs * (PASSING + FILES * (always + 2 * kept))  # each has a server and a process

    limit = _raised(needed(jobs, most))
    if fitting := next((fitting for fitting in range(most, 0, -1) if needed(jobs, fitting) <= limit), 0):
        return fitting
    fewer = next((fewer for fewer in range(jobs - 1, 0, -1) if needed(fewer, 1) <= limit), 0)
    remedy = f"run it with --jobs {fewer}, or allow" if fewer else "allow"
    raise BenchError(
        f"{jobs} jobs of study {study.name!r} need {needed(jobs, 1):,} open files, and this system allows a "
        f"process {limit:,}; {remedy} more (ulimit -n {needed(jobs, most)})"
    )


def _open() -> int:
    """Return the number of files that this process has open."""
    with suppress(psutil.Error):
        return int(psutil.Process().num_fds())
    return 0


def _raised(needed: int) -> int:
    """Return the limit of open files, raised to what is needed as far as the system allows it."""
    if resource is None:
        return sys.maxsize
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft != resource.RLIM_INFINITY and soft < needed:
        with suppress(OSError, ValueError):  # some systems have further limits
            soft = needed if hard == resource.RLIM_INFINITY else min(needed, hard)
            resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
        soft = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    return sys.maxsize if soft == resource.RLIM_INFINITY else soft
