"""Start processes with the same plug-ins loaded: forks of one process where that is safe, new ones elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, suppress
from copy import copy
from threading import Event, Lock
from typing import Any

from bench.sandbox.bubblewrap import Sandbox
from bench.sandbox.process import LostError, Process, RemoteError
from bench.sandbox.server import FORKS


class ForkServer(AbstractContextManager["ForkServer"]):
    """Starts processes in which the same calls were made, and branches into fork servers that make further calls.

    Where processes fork, it holds one that has made the calls, and the processes of its branches are forked from it.
    Elsewhere, and where a fork is unsafe, a process is started anew, in a sandbox of its own, and the calls are made
    again within their limits. One thread uses a fork server and its branches; any may :meth:`kill` them.

    Args:
        hash_seed: PYTHONHASHSEED of the processes.
        sandbox: in which each process that is started anew runs, with its forks, each of which has namespaces of its
            own there; None for none.
    """

    def __init__(self, hash_seed: int = 0, *, sandbox: Sandbox | None = None) -> None:
        self.forks = FORKS and (sandbox is None or sandbox.nests)
        self._hash_seed, self._sandbox = hash_seed, sandbox
        self._lock, self._killed = Lock(), Event()  # these and the next one are shared with all branches
        self._started: list[Process] = []  # anew; forks end with them
        self._calls: list[tuple[Callable[..., object], tuple[object, ...], dict[str, Any]]] = []
        self._process: Process | None = None

    def __exit__(self, *_: object) -> None:
        self.kill()

    def call(self, function: Callable[..., object], *arguments: object, **limits: Any) -> Any:
        """Call a function in all processes that come from here from now on; return the answer.

        Limits and errors are those of :meth:`bench.sandbox.process.Process.call`; after one the call is forgotten.
        """
        answer = self._held().call(function, *arguments, **limits)
        self._calls.append((function, arguments, limits))
        return answer

    def after(self, function: Callable[..., object], *arguments: object, **limits: Any) -> ForkServer:
        """Have all processes make this call first; return this fork server, before it has a process."""
        self._calls.append((function, arguments, limits))
        return self

    def ensure(self, function: Callable[..., object], *arguments: object, **limits: object) -> None:
        """Make a call as :meth:`call` does, unless the processes that come from here have made it already."""
        if not any((function, arguments) == call[:2] for call in self._calls):
            self.call(function, *arguments, **limits)

    def branch(self) -> ForkServer:
        """Return a fork server that begins with the same calls; raises what :meth:`process` raises."""
        branch = copy(self)
        branch._calls, branch._process = [*self._calls], None
        branch._process = self.process()
        return branch

    def process(self) -> Process:
        """Return a process that has made the calls, for its user to close.

        Raises:
            LostError: when the process that it is forked from has ended or does not answer.
            The others of :meth:`bench.sandbox.process.Process.call`: of the calls made again.
        """
        held = self._held()
        fork = held.fork() if self.forks else None
        if fork is None:
            self._process = None  # it is given away, and a new one started for the next
        return fork or held

    def close(self) -> None:
        """End the process that is held, and its forks; another one is started when it is needed."""
        process, self._process = self._process, None
        with suppress(LostError, RemoteError):  # the process that it was forked from has ended, and so has it
            if process is not None:
                process.close()

    def kill(self) -> None:
        """End all processes of this fork server, and of those that it branched from or into; it starts no other."""
        with self._lock:
            self._killed.set()
        for process in self._started:
            process.kill()

    def _held(self) -> Process:
        with self._lock:
            if self._killed.is_set():  # also while its processes are still being ended
                raise LostError("it has been ended")
            if self._process is not None and not self._process.closed:
                return self._process
            self._process = process = Process(self._hash_seed, forks=self.forks, sandbox=self._sandbox)
            self._started[:] = [*(started for started in self._started if not started.closed), process]
        for function, arguments, limits in self._calls:
            process.call(function, *arguments, **limits)
        return process
