"""Strict trials: the problem, the budget and the trace are in another process; only points and values cross.

The server (:func:`serve`) holds the :class:`bench.objective.Objective`. The optimizer's process has no problem in its
memory, and :func:`hide_problems` refuses to import one. Whatever the optimizer does there, each evaluation is counted
and recorded. A message begins with what is asked or answered, one byte; numbers follow, or a text.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from importlib.util import find_spec
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Lock
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bench.objective import BudgetExhausted, Objective, floats
from bench.plugins import registry
from bench.sandbox.messages import describe_error
from bench.typing import Flags, Floats

_EVALUATE, _REPAIR, _INITIAL, _STOP, _BEGIN, _END = (bytes([number]) for number in range(6))
_DONE, _EXHAUSTED, _RAISED = (bytes([number]) for number in range(3))
_LONGEST = 1 << 26  # bytes of the points of a request


class RemoteObjective:
    """What a strict trial gives its optimizer in place of an ``Objective``, with the same contract.

    Args:
        end: the file number of the socket whose other end :func:`serve` serves.
        lower: (d,) lower bounds.
        upper: (d,) upper bounds.
        integer: (d,) bool, the variables that are whole numbers.
        budget: evaluations allowed.
        on_refusal: called with the number of refusals so far whenever points are refused because the budget is spent.
    """

    def __init__(
        self,
        end: int,
        lower: Floats,
        upper: Floats,
        integer: Flags,
        budget: int,
        on_refusal: Callable[[int], None],
    ) -> None:
        self.lower, self.upper, self.integer = lower.copy(), upper.copy(), integer.copy()
        self.lower.flags.writeable = self.upper.flags.writeable = self.integer.flags.writeable = False
        self.budget, self.evaluations = budget, 0
        self.stop_reason: str | None = None
        self._end, self._lock = Connection(end), Lock()
        self._refusals, self._on_refusal = 0, on_refusal

    @property
    def dimension(self) -> int:
        """The number of search variables d."""
        return len(self.lower)

    @property
    def remaining(self) -> int:
        """The number of evaluations left."""
        return self.budget - self.evaluations

    def __call__(self, x: ArrayLike) -> Any:
        """Return the (n,) values of (n, d) points, or the float of one (d,) point; see ``Objective``."""
        points = floats(x, "points")
        rows = points[np.newaxis] if points.ndim == 1 else points
        if rows.ndim != 2 or rows.shape[1] != self.dimension:
            raise ValueError(
                f"expected points of shape (n, {self.dimension}) or ({self.dimension},), got {points.shape}"
            )
        with self._lock:
            exhausted, values = self._ask(_EVALUATE, len(rows), rows.tobytes())
            self.evaluations = self.budget if exhausted else self.evaluations + len(rows)
        if exhausted:
            self._refusals += 1
            self._on_refusal(self._refusals)
            raise BudgetExhausted
        return float(values[0]) if points.ndim == 1 else values

    def repair(self, x: Floats) -> Floats:
        """Return the (n, d) feasible points nearest to ``x`` by the problem's rule; costs no evaluation."""
        points = floats(x, "points")
        rows = np.atleast_2d(points)
        with self._lock:
            return self._ask(_REPAIR, len(rows), rows.tobytes())[1].reshape(points.shape)

    def initial(self, n: int) -> Floats:
        """Return (n, d) points, uniform in the box and then repaired, independent in every trial."""
        with self._lock:
            return self._ask(_INITIAL, n, int(n).to_bytes(8))[1].reshape(n, self.dimension)

    def stop(self, reason: str) -> None:
        """Declare that the optimizer ends before its budget by a criterion of its own, such as ``"tolfun"``."""
        self.stop_reason = str(reason)
        with self._lock:
            self._ask(_STOP, 0, self.stop_reason.encode(errors="replace")[: 1 << 16])

    def begin(self) -> None:
        """Start the clock."""
        self._ask(_BEGIN, 0, b"")

    def end(self) -> None:
        """Stop the clock; no evaluation follows."""
        self._ask(_END, 0, b"")

    def _ask(self, request: bytes, n: int, content: bytes) -> tuple[bool, Floats]:
        """Ask for something about ``n`` points; return whether the budget is spent, and the numbers of the answer."""
        if 8 * n * self.dimension > _LONGEST:
            raise ValueError(f"a strict trial takes {_LONGEST // (8 * self.dimension):,} points at a time, not {n:,}")
        self._end.send_bytes(request + content)
        answer = self._end.recv_bytes()
        if answer[:1] == _RAISED:
            raise RuntimeError(answer[1:].decode(errors="replace"))
        values = np.frombuffer(answer, offset=1).copy()  # for the optimizer to write to
        return answer[:1] == _EXHAUSTED, values


def serve(objective: Objective, file: int) -> float:
    """Answer a :class:`RemoteObjective` until it ends or its process does; return the seconds from begin to end.

    Args:
        objective: what it stands for.
        file: the file number of the socket.

    Raises:
        Exception: what the problem raises, after the optimizer has been given it.
    """
    began = ended = 0.0
    d, raised = objective.dimension, None
    with Connection(file) as end, suppress(EOFError, OSError):
        while not ended:
            message = end.recv_bytes(1 + _LONGEST)
            request, content = message[:1], message[1:]
            n = int.from_bytes(content) if request == _INITIAL else 0
            if 8 * n * d > _LONGEST or (request == _BEGIN) == bool(began):  # the clock begins once, and first
                break
            answer, kind = b"", _DONE
            try:
                if request == _EVALUATE:
                    answer = objective(np.frombuffer(content).reshape(-1, d)).tobytes()
                elif request == _REPAIR:
                    answer = objective.repair(np.frombuffer(content).reshape(-1, d).copy()).tobytes()
                elif request == _INITIAL:
                    answer = objective.initial(n).tobytes()
                elif request == _STOP:
                    objective.stop(content.decode(errors="replace"))
                elif request == _BEGIN:
                    began = perf_counter()
                elif request == _END:
                    ended = perf_counter()
            except BudgetExhausted:
                kind = _EXHAUSTED
            except Exception as error:
                raised = raised or error
                answer, kind = describe_error(error).encode(), _RAISED
            end.send_bytes(kind + answer)
    if raised is not None:
        raise raised
    return (ended or perf_counter()) - began if began else 0.0


def hide_problems() -> None:
    """Refuse to import the installed problems in this process: an optimizer could evaluate them uncounted."""
    hidden = _problem_modules()

    def refuse(event: str, arguments: tuple[object, ...]) -> None:  # no code in Python can undo it
        name = str(arguments[0]) if event == "import" else ""
        if any(name == each or name.startswith(f"{each}.") for each in hidden):
            raise ImportError(f"{name} is hidden from the optimizers of strict trials")

    sys.addaudithook(refuse)


def problem_files() -> Iterator[Path]:
    """Yield the folders and files with the code of the installed problems; none of it is imported for this."""
    for name in _problem_modules():
        top, *parts = name.split(".")
        spec = find_spec(top)
        if spec is None or spec.origin is None:
            continue
        path = Path(spec.origin).parent.joinpath(*parts) if spec.submodule_search_locations else Path(spec.origin)
        yield from (each for each in path.iterdir() if each.name != "__init__.py") if path.is_dir() else [path]


def _problem_modules() -> set[str]:
    """Return the outermost packages that hold installed problems and no installed optimizer."""
    optimizers = [entry.module for entry in registry.entries("optimizers").values()]
    found = set()
    for entry in registry.entries("problems").values():
        parts = entry.module.split(".")
        names = [".".join(parts[: depth + 1]) for depth in range(len(parts))]
        free = [name for name in names if not any(f"{each}.".startswith(f"{name}.") for each in optimizers)]
        found.update(free[:1])
    return found
