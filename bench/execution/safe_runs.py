"""Make single runs in processes that can be lost; a run that fails gives one sentence, and costs the others nothing."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from typing import Any, TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

from bench.contract.optimizer import Optimizer
from bench.contract.problem import Problem
from bench.helpers.errors import BenchError, ProblemError
from bench.helpers.text import printable
from bench.sandbox.callers import Call
from bench.sandbox.messages import describe_error
from bench.sandbox.process import DiedError, PrintedTooMuchError
from bench.sandbox.server import STILL_ASKING, end_if_stuck
from bench.trial.trial import Result, search

PRINTED = 100_000_000
"""Bytes that a process may print in one call: the file that takes them must not fill the disk."""

LONGEST = 4_000  # characters of a sentence on a failure
Found = TypeVar("Found")


def safe_run(problem: Problem, optimizer: Optimizer, *, budget: int, seed: int, name: str = "the optimizer") -> Result:
    """Make one run as a trial is made, but without metrics of its best point.

    A process of a :func:`safe_call` ends where the optimizer keeps asking for values after the end of its budget.

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


def safe_call(
    group: Hashable, function: Callable[..., Mapping[str, Any]], *arguments: object, **limits: object
) -> Call:
    """Return the call of a module's function that makes runs by :func:`safe_run`, for :class:`Callers`.

    The function returns their record: numbers, texts and arrays of numbers, which :func:`found` reads. No process makes
    the calls of two groups. The limits are those of :meth:`bench.sandbox.process.Process.finish`.
    """
    return Call(group, recorded, (function, *arguments), {"printed": PRINTED} | limits)


def found(answer: Any, read: Callable[[dict[str, Any]], Found], what: str = "the optimizer") -> Found:
    """Return what ``read`` makes of the record of a run of ``what``, as sentences call it.

    Args:
        answer: of a :func:`safe_call`, or the error of its process.
        read: called with the record.
        what: the subject of sentences.

    Raises:
        BenchError: where the run failed, its process was lost, or ``read`` raises TypeError, ValueError or KeyError.
    """
    if isinstance(answer, DiedError):
        stuck = answer.code == STILL_ASKING
        why = "went on asking for values after its budget was spent" if stuck else f"ended its process ({answer})"
        raise BenchError(f"{what} {why}")
    if isinstance(answer, PrintedTooMuchError):
        raise BenchError(f"{what} printed more than {PRINTED / 1e6:g} MB in one run")
    if isinstance(answer, Exception):
        raise BenchError(f"{what} failed: {printable(str(answer), LONGEST)}")
    if isinstance(answer, dict) and "error" in answer:
        raise BenchError(printable(str(answer["error"]), LONGEST))
    try:
        return read(answer)
    except (AttributeError, TypeError, ValueError, KeyError) as error:
        raise BenchError(f"the process of {what} gave an answer that is no record of a run") from error


def recorded(function: Callable[..., Mapping[str, Any]], *arguments: object) -> dict[str, Any]:
    """Call a function in this process; return its record, or the error that it ended with, as JSON values.

    Arrays of numbers become lists, in which no digit is lost.
    """
    try:
        found = function(*arguments)
        return {name: each.tolist() if isinstance(each, np.ndarray) else each for name, each in found.items()}
    except BenchError as error:
        return {"error": str(error)}
    except (Exception, SystemExit) as error:  # a plug-in may raise anything
        return {"error": f"the optimizer failed: {describe_error(error)}"}
