"""Call a function for many items in worker processes, so that an item that ends its process costs no other."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from threading import Thread
from typing import TypeVar

Item = TypeVar("Item")
Answer = TypeVar("Answer")

# A fork starts in milliseconds with all that is imported. It is not safe elsewhere, where a worker imports all anew.
FORKS = sys.platform == "linux"


def in_workers(
    work: Callable[[Item], Answer], items: Sequence[Item], jobs: int, lost: Callable[[Item], Answer]
) -> Iterator[Answer]:
    """Yield ``work(item)`` for each item in their order, made in at most ``jobs`` processes.

    An item that ends its process ends all of them: the first one without an answer is then made again alone, and those
    after it in new processes. Where an item ends its process alone, too, the answer is ``lost(item)``. The processes
    end with the generator, and with this process.

    Args:
        work: must be picklable where workers are not forked.
        items: are pickled.
        jobs: at least 1.
        lost: is called in this process.
    """
    answered = 0
    while answered < len(items):
        try:
            with _processes(min(jobs, len(items) - answered)) as pool:
                for answer in pool.map(work, items[answered:]):
                    yield answer
                    answered += 1
        except BrokenProcessPool:
            yield _alone(work, items[answered], lost)
            answered += 1


def _alone(work: Callable[[Item], Answer], item: Item, lost: Callable[[Item], Answer]) -> Answer:
    try:
        with _processes(1) as pool:
            return pool.submit(work, item).result()
    except BrokenProcessPool:
        return lost(item)


@contextmanager
def _processes(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool of processes, which end with the context, whatever they do.

    Where they are started anew, they import nothing from the working folder before they have this process's path.
    """
    earlier = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(jobs, multiprocessing.get_context("fork" if FORKS else "spawn"), _obey_parent)
    safe = {} if FORKS else {"PYTHONSAFEPATH": "1"}
    added = safe.keys() - os.environ
    os.environ.update(safe)
    try:
        yield pool
    finally:
        for name in added:
            del os.environ[name]
        for process in set(multiprocessing.active_children()) - earlier:
            process.kill()
        pool.shutdown(cancel_futures=True)


def _obey_parent() -> None:
    """Have this worker ignore Ctrl-C, which its parent handles, and end with its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    if parent := multiprocessing.parent_process():
        parent.join()
    os._exit(1)
