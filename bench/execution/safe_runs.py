"""Make single runs in processes that can be lost; a run that fails gives one sentence, and costs the others nothing."""

from __future__ import annotations

import base64
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from typing import Any, TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

from bench.errors import BenchError, ProblemError
from bench.helpers.text import printable
from bench.optimizer import Optimizer
from bench.problem import Problem
from bench.sandbox.bubblewrap import Sandbox
from bench.sandbox.messages import describe_error
from bench.sandbox.pool import Pool
from bench.sandbox.process import FAILURES, DiedError, LostError, PrintedTooMuchError
from bench.sandbox.server import STILL_ASKING, end_if_stuck
from bench.trial import Result, search

PRINTED = 100_000_000
"""Bytes that a process may print in one call: the file that takes them must not fill the disk."""

LONGEST = 4_000  # characters of a sentence on a failure
Found = TypeVar("Found")
Begin = Callable[..., Future[Any]]


def safe_run(problem: Problem, optimizer: Optimizer, *, budget: int, seed: int, name: str = "the optimizer") -> Result:
    """Make one run as a trial is made, but without metrics of its best point.

    A process of :func:`safe_runs` ends where the optimizer keeps asking for values after the end of its budget.

    Raises:
        BenchError: where the problem raises, or the optimizer, which the sentence calls ``name``.
    """
    try:
        with threadpool_limits(limits=1):  # results and times must not depend on the number of BLAS threads
            return search(problem, optimizer, budget, seed, end_if_stuck)
    except BenchError:
        raise
    except ProblemError as error:
        raise BenchError(f"{problem.name} failed: {describe_error(error)}") from error
    except (Exception, SystemExit) as error:  # a plug-in may raise anything
        raise BenchError(f"{name} failed on {problem.name}: {describe_error(error)}") from error


@contextmanager
def safe_runs(jobs: int, ready: Callable[[], None], sandbox: Sandbox | None = None) -> Iterator[Begin]:
    """Yield a function that has runs made side by side, none in a process where an optimizer of another group has run.

    It takes the group, a module's function with its arguments, and as keywords the limits of
    :meth:`bench.sandbox.process.Process.call`. The function makes runs by :func:`safe_run` and returns their record:
    numbers, texts and arrays of numbers. :func:`found` and :func:`in_order` wait for it.

    Args:
        jobs: calls made at a time, -1 for one a core.
        ready: loads what all of them need, once.
        sandbox: in which they are made; None for none.
    """
    with Pool(jobs, ready, sandbox) as pool:
        yield lambda group, *call, **limits: pool.submit(group, recorded, *call, printed=PRINTED, **limits)


def found(begun: Future[Any], read: Callable[[dict[str, Any]], Found], what: str = "the optimizer") -> Found:
    """Wait for a run of ``what``, as sentences call it, and return what ``read`` makes of its record.

    Raises:
        BenchError: where the run failed, its process was lost, or ``read`` raises TypeError, ValueError or KeyError.
    """
    try:
        answer = begun.result()
    except DiedError as error:
        stuck = error.code == STILL_ASKING
        why = "went on asking for values after its budget was spent" if stuck else f"ended its process ({error})"
        raise BenchError(f"{what} {why}") from error
    except PrintedTooMuchError as error:
        raise BenchError(f"{what} printed more than {PRINTED / 1e6:g} MB in one run") from error
    except (*FAILURES, LostError) as error:
        raise BenchError(f"{what} failed: {printable(str(error), LONGEST)}") from error
    if isinstance(answer, dict) and "error" in answer:
        raise BenchError(printable(str(answer["error"]), LONGEST))
    try:
        return read({name: _unpacked(value) for name, value in answer.items()})
    except (AttributeError, TypeError, ValueError, KeyError) as error:
        raise BenchError(f"the process of {what} gave an answer that is no record of a run") from error


def in_order(begun: Sequence[Future[Any]], read: Callable[[dict[str, Any]], Found]) -> Iterator[Found]:
    """Yield the results of one optimizer's runs by :func:`found`; the first failure ends the others."""
    try:
        for run in begun:
            yield found(run, read)
    finally:
        for run in begun:
            run.cancel()


def recorded(function: Callable[..., Mapping[str, Any]], *arguments: Any) -> dict[str, Any]:
    """Call a function in this process; return its record, or the error that it ended with, as JSON values."""
    try:
        return {name: _packed(value) for name, value in function(*arguments).items()}
    except BenchError as error:
        return {"error": str(error)}
    except (Exception, SystemExit) as error:  # a plug-in may raise anything
        return {"error": f"the optimizer failed: {describe_error(error)}"}


def _packed(value: Any) -> Any:
    if isinstance(value, np.ndarray):  # thousands of numbers, which would take longer as digits
        return [value.shape, base64.b64encode(value.astype(np.float64).tobytes()).decode()]
    return value


def _unpacked(value: Any) -> Any:
    """Return an array as it was packed, and other values as they are; raises ValueError or TypeError for no array."""
    if isinstance(value, list):
        shape, content = value
        return np.frombuffer(base64.b64decode(content), dtype=np.float64).reshape(shape)
    return value
