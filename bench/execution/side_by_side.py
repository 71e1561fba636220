"""Evaluate the points of a call side by side, each in a process of the problem that may hang, crash or end."""

from __future__ import annotations

import signal
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from copy import copy
from functools import partial
from math import inf
from multiprocessing import get_context, popen_fork
from multiprocessing.connection import Connection, wait
from time import monotonic, perf_counter
from typing import Any

import cloudpickle
import numpy as np
from threadpoolctl import threadpool_limits

from bench.contract.objective import as_values
from bench.contract.problem import Problem
from bench.contract.typing import Floats
from bench.execution.journal import Journal
from bench.helpers.errors import BenchError, PointError, StopRun
from bench.sandbox import tree
from bench.sandbox.messages import describe_error
from bench.sandbox.process import DiedError
from bench.sandbox.server import FORKS
from bench.trial.scoring import Scored

Done = Callable[..., None]
"""Is called for each point evaluated: its row, its value, why it failed ("" where it did not), the seconds, and its
violations, where they were found with the value."""

START = "fork" if FORKS else "spawn"
"""How processes are started; to one that is started anew the problem is sent by value."""

_VALUE, _FAILED, _BEGINS, _STOP = b"+", b"-", b"!", b"."  # the first byte of an answer
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
    if parallel == 1 and seconds is None and journal is None:
        with closing(plain):
            yield problem
        return
    require_possible(problem, parallel, seconds)
    goes_on = isinstance(problem, Scored) and problem.on_error == "worst"
    with ExitStack() as held:
        processes = None
        if parallel > 1 or seconds is not None:
            processes = held.enter_context(closing(_Processes(plain, parallel, seconds, goes_on)))
        else:
            held.enter_context(closing(plain))
        if journal is not None:
            held.enter_context(closing(journal))
        noted = Recorded(plain, processes, goes_on, journal)
        beside = copy(plain)  # all else is computed here
        changed = {"evaluate": noted.values, "noiseless": noted.values, "violations": noted.violations}
        # A class that is pickled by its name has lost the known points.
        for name, value in (changed | {"by_point": False, "initial_points": plain.initial_points}).items():
            object.__setattr__(beside, name, value)  # also of a frozen dataclass
        if isinstance(problem, Scored):
            problem = copy(problem)
            problem.problem = beside
            yield problem
        else:
            yield beside


def require_possible(problem: Problem, parallel: int, seconds: float | None) -> None:
    """Raise BenchError for a noisy problem that is to be evaluated by several processes or within a limit."""
    if problem.unscored.noisy and (parallel > 1 or seconds is not None):
        raise BenchError(
            f"problem {problem.name!r} is noisy, and its noise is drawn for one point after the other; leave out "
            "'parallel' and 'evaluation_timeout'"
        )


class Recorded:
    """The evaluations of a problem in a trial, which may be noted in a journal, or answered from it.

    Args:
        problem: without noise.
        processes: which evaluate its points; None where this one does.
        goes_on: whether the other points of a batch are evaluated where one has failed.
        journal: of the trial, if any.
    """

    def __init__(self, problem: Problem, processes: _Processes | None, goes_on: bool, journal: Journal | None) -> None:
        self._problem, self._goes_on, self._journal = problem, goes_on, journal
        self._whole = processes is None and not problem.by_point  # a value may depend on its batch in the last bits
        self._evaluate = partial(_here, problem, goes_on) if processes is None else processes.points
        self._violations: dict[bytes, Floats] = problem.found if problem.joint else {}

    def values(self, x: Floats) -> Floats:
        """Return the (n,) values of the (n, d) points; raises PointError where any fails."""
        journal = self._journal if self._journal is None or self._journal.slow is not False else None
        if journal is None and isinstance(self._evaluate, partial):
            return self._problem.evaluate(x)
        values, failed = np.full(len(x), inf), dict[int, str]()
        known = journal.answers(x) if journal else {}
        if self._whole and len(known) < len(x):
            known = {}

        def done(row: int, value: float, reason: str, seconds: float, violations: Floats | None = None) -> None:
            values[row] = value
            if reason:
                failed[row] = reason
                violations = np.full(self._problem.joint, inf) if violations is None else violations
            if violations is not None:
                self._violations[x[row].tobytes()] = violations
            if journal and row not in known and journal.takes(reason, seconds, self._goes_on):
                journal.add(row, x[row], value, self._broken(x[row]), seconds, reason)

        for row, record in known.items():
            done(row, record["f"], record.get("error", ""), record["s"], np.array(record["g"], np.float64))
        left = [row for row in range(len(x)) if row not in known]
        if left:
            self._evaluate(x[left], lambda each, *answer: done(left[each], *answer))
        if journal:
            journal.end(len(x), len(known))
        if failed:
            raise PointError(failed[min(failed)], values.tolist(), len(failed))
        return values

    def violations(self, x: Floats) -> Floats | None:
        """Return the (n, m) violations of the (n, d) points, or None without constraints."""
        known = [self._violations.get(row.tobytes()) for row in x]
        if any(each is None or not len(each) for each in known):
            return self._problem.violations(x)
        return np.array(known)

    def _broken(self, point: Floats) -> Floats:
        """Return the (m,) violations of a (d,) point that is noted; they are computed where they are not known."""
        key = point.tobytes()
        if key not in self._violations:
            found = self._problem.violations(point[np.newaxis])
            self._violations[key] = np.empty(0) if found is None else np.ravel(found)
        return self._violations[key]


def _here(problem: Problem, goes_on: bool, x: Floats, done: Done) -> None:
    """Evaluate points in this process: one after the other where the problem does so itself, else together."""
    for first, part in enumerate(x[:, np.newaxis] if problem.by_point else [x]):
        began, reason = perf_counter(), ""
        try:
            values = as_values(problem, problem.evaluate(part.copy()), len(part))
        except Exception as error:  # a plug-in may raise anything
            if not (problem.by_point and goes_on):
                raise
            values, reason = np.full(1, inf), describe_error(error)
        seconds = (perf_counter() - began) / len(part)
        for row, value in enumerate(values.tolist(), start=first):
            done(row, value, reason, seconds)


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
        self._all: dict[Connection, Any] = {}  # by the connection through which each is asked
        self._idle = [self._started() for _ in range(number)]

    def close(self) -> None:
        """End all processes, and what they have started."""
        for end in self._all:
            end.close()  # which ends an idle one
        until = monotonic() + _GRACE
        for process in self._all.values():
            process.join(max(0.0, until - monotonic()))
            _kill(process)

    def points(self, x: Floats, done: Done) -> None:
        """Evaluate the (n, d) points; none is begun after one that failed, unless the others go on."""
        began, failed = dict[int, float](), False
        left, busy = iter(range(len(x))), dict[Any, tuple[int, float]]()
        while True:
            while self._idle and (self._goes_on or not failed) and (row := next(left, None)) is not None:
                end = self._idle.pop()
                with suppress(OSError):  # its process has ended, which is found below
                    end.send_bytes(x[row].tobytes())
                busy[end], began[row] = (row, monotonic() + self._seconds + _OPENING), monotonic()
            if not busy:
                return
            until = min(deadline for _, deadline in busy.values())
            ready: list[Any] = wait(busy, None if until == inf else max(0.0, until - monotonic()))
            for end in ready or [end for end in busy if busy[end][1] <= monotonic()]:
                row, _ = busy.pop(end)
                message = _received(end) if ready else b""
                if message == _BEGINS:
                    busy[end], began[row] = (row, monotonic() + self._seconds), monotonic()
                    continue
                if message[:1] == _STOP:
                    raise StopRun(message[1:].decode(errors="replace"))
                numbers, reason = [inf], ""
                if not message:
                    reason = self._replace(end, late=not ready)
                else:
                    self._idle.append(end)
                    if message[:1] == _FAILED:
                        reason = message[1:].decode(errors="replace")
                    else:
                        numbers = np.frombuffer(message, offset=1).tolist()
                failed = failed or bool(reason)
                violations = np.array(numbers[1:]) if self._problem.joint and not reason else None
                done(row, numbers[0], reason, monotonic() - began[row], violations)

    def _replace(self, end: Any, *, late: bool = False) -> str:
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
        problem: Any = self._problem if START == "fork" else cloudpickle.dumps(self._problem)
        process = self._context.Process(
            target=_serve, args=(problem, end, [own, *self._all] if START == "fork" else [])
        )
        with warnings.catch_warnings():  # that threads of this process may hold locks: the copy runs the problem alone
            warnings.simplefilter("ignore", DeprecationWarning)
            process.start()
        end.close()
        self._all[own] = process
        return own  # type: ignore[no-any-return]


def _received(end: Any) -> bytes:
    """Return the message of a process, b"" where it has ended."""
    try:
        return bytes(end.recv_bytes())
    except (EOFError, OSError):
        return b""


def _kill(process: Any) -> None:
    """End a process and what it has started, unless it has ended by itself."""
    if process.exitcode is None:
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
            x = np.frombuffer(end.recv_bytes()).reshape(1, -1).copy()  # the problem may compute in it
            try:
                loaded.open()
                end.send_bytes(_BEGINS)
                point = x.copy()
                answer = _VALUE + as_values(loaded, loaded.evaluate(x), 1).tobytes()
                answer += loaded.found.pop(point.tobytes()).tobytes() if loaded.joint else b""
            except StopRun as stopped:
                answer = _STOP + str(stopped).encode()
            except (Exception, SystemExit) as error:  # a plug-in may raise anything
                answer = _FAILED + describe_error(error).encode()
            end.send_bytes(answer)
