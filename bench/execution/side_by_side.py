"""Evaluate the points of a call: its journal answers, or processes that may hang, crash or end, or this one."""

from __future__ import annotations

import signal
import warnings
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from copy import copy
from itertools import chain
from math import inf
from multiprocessing import get_context, popen_fork
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from time import monotonic, perf_counter
from typing import Any

import cloudpickle
import numpy as np
from threadpoolctl import threadpool_limits

from bench.contract.objective import as_values
from bench.contract.problem import Problem
from bench.contract.typing import Floats
from bench.execution.journal import Journal, Record
from bench.helpers.errors import BenchError, PointError, StopRun
from bench.helpers.text import count
from bench.sandbox import tree
from bench.sandbox.messages import describe_error
from bench.sandbox.process import DiedError
from bench.sandbox.server import FORKS
from bench.trial.scoring import Scored
from bench.trial.scoring.problem import violations_of

START = "fork" if FORKS else "spawn"
"""How processes are started; to one that is started anew the problem is sent by value."""

_OPENING = 60.0  # seconds for a problem to get ready for an evaluation
_GRACE = 1.0  # seconds for a process to end by itself
_ = popen_fork  # imported before any trial, whose side effect it would be


@contextmanager
def evaluated(
    problem: Problem, parallel: int = 1, seconds: float | None = None, journal: Journal | None = None
) -> Iterator[Problem]:
    """Yield a problem as a trial evaluates it; at the end, let go of what its evaluations hold.

    With ``parallel`` above 1 or a limit of ``seconds``, the points of a call are evaluated by that many processes of
    the problem, each point alone. The values, their order and the reason of a failure are those of a call without. A
    point whose evaluation takes too long, or ends its process, fails alone (:class:`bench.helpers.errors.PointError`).

    Args:
        problem: as a study scores it.
        parallel: points evaluated at a time.
        seconds: wall seconds that the evaluation of a point may take.
        journal: notes slow evaluations and answers those of an earlier attempt, of a problem without noise.

    Raises:
        BenchError: for a noisy problem, whose noise is drawn for one point after the other.
    """
    plain = problem.unscored
    with ExitStack() as held:
        beside = parallel > 1 or seconds is not None
        if not (beside or journal or plain.joint):
            held.enter_context(closing(plain))
            yield problem
            return
        require_possible(problem, parallel, seconds)
        goes_on = isinstance(problem, Scored) and problem.on_error == "worst"
        processes = _Processes(plain, parallel, seconds, goes_on) if beside else None
        held.enter_context(closing(processes or plain))
        if journal:
            held.enter_context(closing(journal))
        answers = Evaluations(plain, goes_on, processes, journal)
        answered = copy(plain)  # all else is computed here
        changed = {"evaluate": answers.values, "noiseless": answers.values, "violations": answers.violations}
        # A class that is pickled by its name has lost the known points.
        for name, value in (changed | {"by_point": False, "initial_points": plain.initial_points}).items():
            object.__setattr__(answered, name, value)  # also of a frozen dataclass
        if isinstance(problem, Scored):
            problem = copy(problem)
            problem.problem = answered
            yield problem
        else:
            yield answered


def require_possible(problem: Problem, parallel: int, seconds: float | None) -> None:
    """Raise BenchError for a noisy problem that is to be evaluated by several processes or within a limit."""
    if problem.unscored.noisy and (parallel > 1 or seconds is not None):
        raise BenchError(
            f"problem {problem.name!r} is noisy, and its noise is drawn for one point after the other; leave out "
            "'parallel' and 'evaluation_timeout'"
        )


class Evaluations:
    """The evaluations of a trial, each made once: those that its journal does not answer.

    Args:
        problem: without noise.
        goes_on: whether the other points of a batch are evaluated where one has failed.
        processes: evaluate its points; None where this process does.
        journal: of the trial, if any.
    """

    def __init__(
        self, problem: Problem, goes_on: bool, processes: _Processes | None = None, journal: Journal | None = None
    ) -> None:
        self._problem, self._goes_on, self._processes, self._journal = problem, goes_on, processes, journal
        self._found: dict[bytes, list[float]] = {}  # violations by the bytes of their point
        self._number: int | None = None  # of violations that the problem finds with a value

    def values(self, x: Floats) -> Floats:
        """Return the (n,) values of the (n, d) points; raises PointError where any fails."""
        journal = self._journal if self._journal and self._journal.slow is not False else None
        if not (journal or self._processes or self._problem.joint):
            return self._problem.evaluate(x)
        known = journal.answers(x) if journal else {}
        if not (self._processes or self._problem.by_point) and len(known) < len(x):
            known = {}  # a value may depend on its batch in the last bits
        rows = [row for row in range(len(x)) if row not in known]
        made = self._processes.records(x, rows) if self._processes else self._here(x, rows)
        values, failed = np.full(len(x), inf), dict[int, str]()
        for row, record in chain(known.items(), made):
            failed |= {row: error} if (error := self._error(x[row], record)) else {}
            values[row] = record["f"]
            if journal and row not in known and (self._goes_on or row not in failed):
                journal.add(row, x[row], record)
        if journal:
            journal.end(len(x), len(known))
        if failed:
            raise PointError(failed[min(failed)], values.tolist(), len(failed))
        return values

    def violations(self, x: Floats) -> Floats | None:
        """Return the (n, m) violations of the (n, d) points, or None without constraints."""
        known = [self._found.get(row.tobytes(), [inf] if self._problem.joint else None) for row in x]
        rows = [each for each in known if each is not None]
        if len(rows) < len(x):
            return self._problem.violations(x)
        most = max(map(len, rows), default=0)  # a point that failed has one
        return np.array([each + [0.0] * (most - len(each)) for each in rows]).reshape(len(x), most)

    def _error(self, point: Floats, record: Record) -> str:
        """Return why a point failed, "" where it did not; keep its violations, which are as many as of the first."""
        if "g" in record:
            number = len(record["g"])
            self._number = number if self._number is None else self._number
            if number == self._number:
                self._found[point.tobytes()] = record["g"]
            else:
                what = f"problem {self._problem.name!r} returned {count(number, 'violation')}"
                record |= {"f": inf, "error": f"{what}, and {self._number} in its first answer"}
                del record["g"]
        return str(record.get("error", ""))

    def _here(self, x: Floats, rows: list[int]) -> Iterator[tuple[int, Record]]:
        """Yield the records of rows of (n, d) points: one after the other where the problem does so, else together."""
        alone = self._problem.by_point
        for part in [[row] for row in rows] if alone else filter(None, [rows]):
            began = perf_counter()
            try:
                records = _records(self._problem, x[part])
            except Exception as error:  # a plug-in may raise anything
                if not (alone and self._goes_on):
                    raise
                records = [{"f": inf, "error": describe_error(error)}]
            seconds = (perf_counter() - began) / len(part)
            yield from ((row, {**record, "s": seconds}) for row, record in zip(part, records, strict=True))


def _records(problem: Problem, x: Floats) -> list[Record]:
    """Evaluate (n, d) points; return their values and violations."""
    values = as_values(problem, problem.evaluate(x.copy()), len(x)).tolist()  # it may compute in its argument
    return [{"f": value, "g": excess} for value, excess in zip(values, violations_of(problem, x).tolist(), strict=True)]


class _Processes:
    """Processes of a problem that evaluate a point at a time each, and are replaced where they are lost.

    Args:
        problem: without noise.
        number: of processes.
        seconds: that the evaluation of a point may take.
        goes_on: whether the other points of a batch are evaluated where one has failed.
    """

    def __init__(self, problem: Problem, number: int, seconds: float | None, goes_on: bool) -> None:
        self._problem, self._goes_on = problem, goes_on
        self._seconds = inf if seconds is None else seconds
        self._context: Any = get_context(START)
        self._all: dict[Connection, BaseProcess] = {}  # by the connection through which each is asked
        self._idle = [self._started() for _ in range(number)]

    def close(self) -> None:
        """End all processes, and what they have started."""
        for end in self._all:
            end.close()  # which ends an idle one
        until = monotonic() + _GRACE
        for process in self._all.values():
            process.join(max(0.0, until - monotonic()))
            _kill(process)

    def records(self, x: Floats, rows: Sequence[int]) -> Iterator[tuple[int, Record]]:
        """Yield the records of rows of (n, d) points; none is begun after one that failed, unless the others go on."""
        left, failed = iter(rows), False
        busy = dict[Connection, tuple[int, float, float]]()  # the row, when it began, and when it is late
        while True:
            while self._idle and (self._goes_on or not failed) and (row := next(left, None)) is not None:
                end = self._idle.pop()
                with suppress(OSError):  # its process has ended, which is found below
                    end.send(x[row])
                busy[end] = row, monotonic(), monotonic() + self._seconds + _OPENING
            if not busy:
                return
            until = min(late for _, _, late in busy.values())
            ready: list[Any] = wait(busy, None if until == inf else max(0.0, until - monotonic()))
            for end in ready or [end for end in busy if busy[end][2] <= monotonic()]:
                row, began, _ = busy.pop(end)
                match _received(end) if ready else None:
                    case "begins":
                        busy[end] = row, monotonic(), monotonic() + self._seconds
                        continue
                    case StopRun() as stopped:
                        raise stopped
                    case dict(record):
                        self._idle.append(end)
                    case _:
                        record = {"f": inf, "error": self._replace(end, late=not ready)}
                failed = failed or "error" in record
                yield row, record | {"s": monotonic() - began}

    def _replace(self, end: Connection, *, late: bool = False) -> str:
        """End a process and start another one; return why, in a sentence."""
        process = self._all.pop(end)
        process.join(0.0 if late else _GRACE)
        code = process.exitcode
        _kill(process)
        end.close()
        self._idle.append(self._started())
        if late:
            return f"an evaluation took more than {self._seconds:g} s (evaluation_timeout)"
        return "an evaluation ended its process" + (f" with {DiedError(code)}" if code is not None else "")

    def _started(self) -> Connection:
        """Start a process; return the connection through which it is asked."""
        own, end = self._context.Pipe()
        problem: object = self._problem if START == "fork" else cloudpickle.dumps(self._problem)
        process = self._context.Process(
            target=_serve, args=(problem, end, [own, *self._all] if START == "fork" else [])
        )
        with warnings.catch_warnings():  # that threads of this process may hold locks: the copy runs the problem alone
            warnings.simplefilter("ignore", DeprecationWarning)
            process.start()
        end.close()
        self._all[own] = process
        return own  # type: ignore[no-any-return]


def _received(end: Connection) -> object:
    """Return what a process sent, None where it has ended."""
    try:
        return end.recv()
    except (EOFError, OSError):
        return None


def _kill(process: BaseProcess) -> None:
    """End a process and what it has started, unless it has ended by itself."""
    if process.pid is not None and process.exitcode is None:
        tree.kill(process.pid)
        process.join()


def _serve(problem: Problem | bytes, end: Connection, others: list[Connection]) -> None:
    """Evaluate the points that are sent, one at a time, until the connection ends.

    Args:
        problem: as an object, or by value.
        end: of the connection.
        others: those of the process that this one was forked from: a copy would hide that they have ended.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the process that asks, and this one with it
    for other in others:
        other.close()
    if isinstance(problem, bytes):
        threadpool_limits(limits=1)
    loaded: Problem = cloudpickle.loads(problem) if isinstance(problem, bytes) else problem
    with suppress(EOFError, OSError), closing(loaded):
        while True:
            x = end.recv()[np.newaxis]
            answer: object
            try:
                loaded.open()
                end.send("begins")
                (answer,) = _records(loaded, x)
            except StopRun as stopped:
                answer = StopRun(str(stopped))
            except (Exception, SystemExit) as error:  # a plug-in may raise anything
                answer = {"f": inf, "error": describe_error(error)}
            end.send(answer)
