"""Trials whose problem, budget and trace are in another process than the optimizer; only points and values cross.

There, :func:`serve` holds the :class:`bench.contract.objective.Objective` that counts. The optimizer's process has an
objective of a :class:`RemoteProblem`, but no problem in its memory, and :func:`hide_problems` refuses to import one.
Whatever the optimizer does there, each evaluation is counted and recorded. A message begins with what is asked or
answered, one byte; numbers follow, or a text. The first request starts the clock, and the end of the connection
stops it.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import suppress
from importlib.util import find_spec
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Lock
from time import perf_counter

import numpy as np

from bench.contract.objective import Objective
from bench.contract.problem import Problem
from bench.contract.typing import Floats
from bench.execution.answers import Box
from bench.helpers.errors import BudgetExhausted
from bench.plugins import registry
from bench.sandbox.messages import describe_error

_EVALUATE, _REPAIR = (bytes([number]) for number in range(2))
_DONE, _EXHAUSTED, _RAISED = (bytes([number]) for number in range(3))
_LONGEST = 1 << 26  # bytes of the points of a request


class RemoteProblem(Problem):
    """A problem as the process of an optimizer has it where it is kept apart: :func:`serve` makes each evaluation.

    Args:
        end: the file number of the socket whose other end is served.
        box: of that problem.
    """

    def __init__(self, end: int, box: Box) -> None:
        self.name = "a problem in another process"
        self.lower, self.upper, self.integer, self.initial_points = box.lower, box.upper, box.integer, box.initial
        self._end, self._lock = Connection(end), Lock()
        self._ask(_EVALUATE, b"")  # no point, which starts the clock

    def evaluate(self, x: Floats) -> Floats:
        """Return the values of the served objective at the (n, d) points."""
        return self._ask(_EVALUATE, x.tobytes())

    def repair(self, x: Floats) -> Floats:
        """Return the (n, d) feasible points nearest to ``x`` by the problem's rule."""
        return self._ask(_REPAIR, x.tobytes()).reshape(x.shape)

    def close(self) -> None:
        """Stop the clock, after which no evaluation follows."""
        self._end.close()

    def _ask(self, request: bytes, content: bytes) -> Floats:
        """Return the numbers of the answer; raises BudgetExhausted where the budget is spent there."""
        if len(content) > _LONGEST:
            point = 8 * self.dimension
            most, asked = _LONGEST // point, len(content) // point
            raise ValueError(f"a problem in another process takes {most:,} points at a time, not {asked:,}")
        with self._lock:
            self._end.send_bytes(request + content)
            answer = self._end.recv_bytes()
        if answer[:1] == _EXHAUSTED:
            raise BudgetExhausted
        if answer[:1] == _RAISED:
            raise RuntimeError(answer[1:].decode(errors="replace"))
        return np.frombuffer(answer, offset=1).copy()  # for the optimizer to write to


def serve(objective: Objective, file: int) -> float:
    """Answer a :class:`RemoteProblem` until it is closed or its process ends; return the seconds since it began.

    What the problem raises, the optimizer is given.

    Args:
        objective: of the problem that it stands for; it counts and records all evaluations, and notes such exceptions.
        file: the file number of the socket.
    """
    began = 0.0
    with Connection(file) as end, suppress(EOFError, OSError):
        while True:
            message = end.recv_bytes(1 + _LONGEST)
            began = began or perf_counter()
            answer, kind = b"", _DONE
            try:
                points = np.frombuffer(message, offset=1).reshape(-1, objective.dimension)
                values = objective(points) if message[:1] == _EVALUATE else objective.repair(points)
                answer = values.tobytes()
            except BudgetExhausted:
                kind = _EXHAUSTED
            except Exception as error:
                answer, kind = describe_error(error).encode(), _RAISED
            end.send_bytes(kind + answer)
    return perf_counter() - began if began else 0.0


def hide_problems() -> None:
    """Refuse to import the installed problems in this process: an optimizer could evaluate them uncounted."""
    hidden = _problem_modules()

    def refuse(event: str, arguments: tuple[object, ...]) -> None:  # no code in Python can undo it
        name = str(arguments[0]) if event == "import" else ""
        if any(name == module or name.startswith(f"{module}.") for module in hidden):
            raise ImportError(f"{name} is hidden from optimizers here")

    sys.addaudithook(refuse)


def problem_files() -> Iterator[Path]:
    """Yield the folders and files with the code of the installed problems; none of it is imported for this."""
    for name in _problem_modules():
        top, *parts = name.split(".")
        spec = find_spec(top)
        if spec is None or spec.origin is None:
            continue
        path = Path(spec.origin).parent.joinpath(*parts) if spec.submodule_search_locations else Path(spec.origin)
        yield from (file for file in path.iterdir() if file.name != "__init__.py") if path.is_dir() else [path]


def _problem_modules() -> set[str]:
    """Return the outermost packages that hold installed problems and no installed optimizer."""
    optimizers = [entry.module for entry in registry.entries("optimizers").values()]
    outermost = set()
    for entry in registry.entries("problems").values():
        parts = entry.module.split(".")
        names = [".".join(parts[: depth + 1]) for depth in range(len(parts))]
        free = [name for name in names if not any(f"{module}.".startswith(f"{name}.") for module in optimizers)]
        outermost.update(free[:1])
    return outermost
