"""Share the open files that this process may have among the jobs of a run."""

from __future__ import annotations

from contextlib import suppress

from bench.errors import BenchError

try:
    import resource
except ImportError:  # on Windows, which counts no sockets
    resource = None  # type: ignore[assignment]

KEPT = 64  # warmed-up optimizers of a job at most; more are warmed up again when their turn comes
EACH = 4  # files of a warmed-up optimizer: the channels and the outputs of two processes
JOB = 40  # all others of a job, while it starts a process: those of the processes from which that is forked
RESERVE = 64  # for all else: the store, figures, modules that are imported


def kept(n_jobs: int) -> int:
    """Return how many warmed-up optimizers each job may keep; the soft limit of open files is raised for that.

    Raises:
        BenchError: where the hard limit is too low for one each.
    """
    if resource is None:
        return KEPT
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = RESERVE + n_jobs * (JOB + EACH * KEPT)
    if 0 <= soft < wanted:  # -1 is no limit
        with suppress(OSError, ValueError):  # some systems have further limits
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted if hard < 0 else min(wanted, hard), hard))
        soft = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    fitting = ((soft if soft >= 0 else wanted) - RESERVE) // n_jobs - JOB
    if fitting < EACH:
        fewer = max(1, (soft - RESERVE) // (JOB + EACH))
        raise BenchError(
            f"{n_jobs} jobs need {RESERVE + n_jobs * (JOB + EACH):,} open files, and this system allows a process "
            f"{soft:,}; run {fewer} at a time (--jobs {fewer}), or allow more (ulimit -n {wanted})"
        )
    return min(KEPT, fitting // EACH)
