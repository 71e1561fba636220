"""Strict trials: the problem, the budget and the trace are in another process; only points and values cross.

The keeper holds the :class:`bench.objective.Objective`. The optimizer's process has no problem in its memory, and
:func:`hide_problems` refuses to import one. Whatever the optimizer does there, each evaluation is counted and recorded.
"""

from __future__ import annotations

import socket
import struct
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from importlib.util import find_spec
from io import BufferedReader
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

_HEAD = struct.Struct("<BQ")  # what is asked or answered, and how many rows (or bytes of text) come with it
_EVALUATE, _REPAIR, _INITIAL, _STOP, _BEGIN, _END = range(6)
_DONE, _EXHAUSTED, _RAISED = range(3)
_LONGEST = 1 << 26  # bytes of the points of a request
_CHUNK = 1 << 16  # bytes read at once: a message and its head rarely need two reads


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
        self._end, self._lock = _opened(end), Lock()
        self._arriving = _arriving(self._end)
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
            exhausted, values = self._ask(_EVALUATE, len(rows), rows, 1)
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
            return self._ask(_REPAIR, len(rows), rows, self.dimension)[1].reshape(points.shape)

    def initial(self, n: int) -> Floats:
        """Return (n, d) points, uniform in the box and then repaired, independent in every trial."""
        with self._lock:
            return self._ask(_INITIAL, n, np.empty(0), self.dimension)[1].reshape(n, self.dimension)

    def stop(self, reason: str) -> None:
        """Declare that the optimizer ends before its budget by a criterion of its own, such as ``"tolfun"``."""
        self.stop_reason = str(reason)
        text = self.stop_reason.encode(errors="replace")[: 1 << 16]
        with self._lock:
            self._ask(_STOP, len(text), np.frombuffer(text, dtype=np.uint8), 0)

    def begin(self) -> None:
        """Start the clock."""
        self._ask(_BEGIN, 0, np.empty(0), 0)

    def end(self) -> None:
        """Stop the clock; no evaluation follows."""
        self._ask(_END, 0, np.empty(0), 0)

    def _ask(self, request: int, n: int, rows: np.ndarray[Any, Any], width: int) -> tuple[bool, Floats]:
        """Return whether the budget is spent, and the (n * width,) numbers of the answer."""
        if 8 * n * self.dimension > _LONGEST:
            raise ValueError(f"a strict trial takes {_LONGEST // (8 * self.dimension):,} points at a time, not {n:,}")
        self._end.sendall(_HEAD.pack(request, n) + rows.tobytes())
        kind, count = _HEAD.unpack(_receive(self._arriving, _HEAD.size))
        if kind == _RAISED:
            raise RuntimeError(_receive(self._arriving, count).decode(errors="replace"))
        values = np.empty(count * width)  # the optimizer's own, to write to
        values.data.cast("B")[:] = _receive(self._arriving, values.nbytes)
        return kind == _EXHAUSTED, values


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
    with _opened(file) as end, _arriving(end) as arriving, suppress(EOFError, OSError):
        while not ended:
            request, n = _HEAD.unpack(_receive(arriving, _HEAD.size))
            if 8 * n * d > _LONGEST or (request == _BEGIN) == bool(began):  # the clock begins once, and first
                break
            answer, kind, count = np.empty(0), _DONE, 0
            try:
                if request == _EVALUATE:
                    points = np.frombuffer(_receive(arriving, 8 * n * d)).reshape(n, d)
                    answer, count = objective(points), n
                elif request == _REPAIR:
                    points = np.frombuffer(_receive(arriving, 8 * n * d)).reshape(n, d).copy()
                    answer, count = objective.repair(points), n
                elif request == _INITIAL:
                    answer, count = objective.initial(n), n
                elif request == _STOP:
                    objective.stop(_receive(arriving, n).decode(errors="replace"))
                elif request == _BEGIN:
                    began = perf_counter()
                elif request == _END:
                    ended = perf_counter()
            except BudgetExhausted:
                kind = _EXHAUSTED
            except Exception as error:
                raised = raised or error
                answer = np.frombuffer(describe_error(error).encode(), dtype=np.uint8)
                kind, count = _RAISED, len(answer)
            end.sendall(_HEAD.pack(kind, count) + answer.tobytes())
    if raised is not None:
        raise raised
    return (ended or perf_counter()) - began if began else 0.0


def _opened(file: int) -> socket.socket:
    end = socket.socket(fileno=file)
    end.setblocking(True)  # a plug-in may have set another default
    return end


def _arriving(end: socket.socket) -> BufferedReader:
    return BufferedReader(socket.SocketIO(end, "r"), _CHUNK)


def _receive(arriving: BufferedReader, length: int) -> bytes:
    data = arriving.read(length)
    if len(data) < length:
        raise EOFError
    return data


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
