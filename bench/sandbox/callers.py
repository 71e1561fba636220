"""Call functions side by side, in processes that end with the context."""

from __future__ import annotations

from collections.abc import Callable, Generator, Hashable, Iterable
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass, field
from threading import Semaphore
from typing import Any

from joblib import effective_n_jobs

from bench.helpers.parallel import side_by_side
from bench.sandbox.bubblewrap import Sandbox
from bench.sandbox.forks import ForkServer
from bench.sandbox.process import FAILURES, LostError, Process, RemoteError

LOADING = 300.0  # seconds for a process to load the modules that it needs


@dataclass(frozen=True)
class Call:
    """A call of a module's function; processes that make those of one group make no others.

    Attributes:
        limits: of :meth:`bench.sandbox.process.Process.finish`.
        wanted: asked when its turn comes; a call that is not wanted any more is answered by None.
    """

    group: Hashable
    function: Callable[..., object]
    arguments: tuple[object, ...] = ()
    limits: dict[str, Any] = field(default_factory=dict)
    wanted: Callable[[], bool] = lambda: True


class Callers(AbstractContextManager["Callers"]):
    """Some processes, each of which makes one call after the other, and is replaced after any error.

    Args:
        n_jobs: calls made at a time, -1 for one a core.
        ready: a function that takes and returns nothing; every process calls it first, and has then loaded its module.
        sandbox: in which all processes run; None for none.
    """

    def __init__(self, n_jobs: int, ready: Callable[[], None], sandbox: Sandbox | None = None) -> None:
        self._callers = [_Caller(ready, sandbox) for _ in range(effective_n_jobs(n_jobs))]
        self._idle, self._free = [*self._callers], Semaphore(len(self._callers))

    def __exit__(self, *_: object) -> None:
        self.kill()

    def kill(self) -> None:
        """End all processes; calls then end with an error."""
        for caller in self._callers:
            caller.server.kill()

    def answers(self, calls: Iterable[Call]) -> Generator[tuple[Call, Any]]:
        """Yield each call with its answer, or with the error of its process, in their order."""
        return side_by_side(self.answer, calls, len(self._callers), end=self.kill)

    def answer(self, call: Call) -> tuple[Call, Any]:
        """Wait for an idle process and return the call with its answer, or with the error of its process."""
        with self._free:
            caller = self._idle.pop()
            try:
                return call, caller.call(call) if call.wanted() else None
            except (*FAILURES, LostError) as error:
                return call, error
            finally:
                self._idle.append(caller)


class _Caller:
    """Makes calls one at a time; its fork server runs no plug-in, its process those of one group."""

    def __init__(self, ready: Callable[[], None], sandbox: Sandbox | None) -> None:
        self.server = ForkServer(sandbox=sandbox).after(ready, seconds=LOADING)
        self._process: Process | None = None
        self._group: Hashable = None

    def call(self, call: Call) -> Any:
        limits = {"seconds": None} | call.limits
        try:
            if self._process is None or self._process.closed or call.group != self._group:
                with suppress(LostError, RemoteError):  # what it was forked from has ended, and it with that
                    if self._process is not None:
                        self._process.close()
                self._process, self._group = self.server.process(), call.group
            return self._process.call(call.function, *call.arguments, **limits)
        except LostError:  # no other error says anything of the process that it was forked from
            self.server.close()
            raise
