"""Call a function for many items in worker processes, so that an item that ends its process costs no other."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, wait
from threading import Thread
from typing import Any, TypeVar

Item = TypeVar("Item")
Answer = TypeVar("Answer")

# A fork starts in milliseconds with all that is imported. It is not safe elsewhere, where a worker imports all anew.
FORKS = sys.platform == "linux"
REAPED = 5.0  # seconds for a process that has closed its pipe to end


def in_workers(
    work: Callable[[Item], Answer], items: Sequence[Item], jobs: int, lost: Callable[[Item, str], Answer]
) -> Iterator[Answer]:
    """Yield ``work(item)`` for each item in their order, made in at most ``jobs`` processes.

    Where an item ends its process, the answer is ``lost(item, how)``, such as how = "signal SIGKILL", and another
    process makes the items after it. The processes end with the generator, and with this process.

    Args:
        work: must be picklable where workers are not forked.
        items: are pickled.
        jobs: at least 1.
        lost: is called in this process.
    """
    waiting = list(range(len(items)))[::-1]
    answers: dict[int, Answer] = {}
    workers: set[_Worker] = set()
    busy: dict[Any, tuple[_Worker, int]] = {}  # by the pipe

    def give(worker: _Worker) -> None:
        number = waiting.pop()
        with suppress(OSError):  # of a process that has just been killed; its pipe has an end instead of an answer
            worker.pipe.send(items[number])
        busy[worker.pipe] = worker, number

    def start() -> _Worker:
        workers.add(worker := _Worker(work))
        return worker

    try:
        for _ in range(min(jobs, len(items))):
            give(start())
        for following in range(len(items)):
            while following not in answers:
                for pipe in wait(list(busy)):
                    worker, number = busy.pop(pipe)
                    try:
                        answers[number] = worker.pipe.recv()
                    except (EOFError, OSError):
                        workers.remove(worker)
                        answers[number] = lost(items[number], worker.died())
                    if waiting:
                        give(worker if worker in workers else start())
            yield answers.pop(following)
    finally:
        for worker in workers:
            worker.end()


class _Worker:
    """A process that calls a function for one item after another."""

    def __init__(self, work: Callable[[Any], Any]) -> None:
        context: Any = multiprocessing.get_context("fork" if FORKS else "spawn")
        self.pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(work, theirs), daemon=True)
        with _interrupts_blocked():
            self._process.start()
        theirs.close()

    def died(self) -> str:
        """Return how the process ended."""
        self._process.join(REAPED)
        code = self._process.exitcode
        self.end()
        if code is None or code >= 0:
            return f"exit code {code or 0}"
        return f"signal {signal.Signals(-code).name}"

    def end(self) -> None:
        """End the process, whatever it does."""
        self._process.kill()
        self._process.join()
        self.pipe.close()


def _serve(work: Callable[[Any], Any], pipe: Connection) -> None:
    """Answer items until the parent ends this process, or ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, daemon=True).start()
    while True:
        try:
            item = pipe.recv()
        except EOFError:
            return
        answer = work(item)
        with suppress(OSError):  # the parent has ended
            pipe.send(answer)


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
    os._exit(1)


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Block SIGINT; a process started meanwhile never receives it, as its parent handles Ctrl-C."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
