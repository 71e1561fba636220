"""Have functions that run an optimizer called in other processes, and say in one sentence why one gave no answer."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from concurrent.futures import Future
from typing import Any

from bench.check.conformance.subject import PRINTED
from bench.check.verdict import LONGEST
from bench.errors import BenchError
from bench.helpers.text import printable
from bench.sandbox.pool import Pool
from bench.sandbox.process import FAILURES, DiedError, LostError, PrintedTooMuchError
from bench.sandbox.server import STILL_ASKING

NO_RECORD = "the optimizer's process gave an answer that is no record of a run"


def submit(
    pool: Pool,
    group: Hashable,
    function: Callable[..., Any],
    *arguments: Any,
    seconds: float | None = None,
    memory: int | None = None,
) -> Future[Any]:
    """Have a function called in a process of the group, within limits; it may print ``PRINTED`` bytes."""
    return pool.submit(group, function, *arguments, seconds=seconds, memory=memory, printed=PRINTED)


def answers(begun: Sequence[Future[Any]]) -> Iterator[Any]:
    """Yield the answers of the calls of one optimizer in order; after the first that fails the others are given up.

    Raises:
        BenchError: where a call had no answer, or the answer ``{"error": why}``.
    """
    try:
        for future in begun:
            yield _answer(future)
    finally:
        for future in begun:
            future.cancel()


def _answer(future: Future[Any]) -> Any:
    try:
        answer = future.result()
    except DiedError as error:
        stuck = error.code == STILL_ASKING
        why = "went on asking for values after its budget was spent" if stuck else f"ended its process ({error})"
        raise BenchError(f"the optimizer {why}") from error
    except PrintedTooMuchError as error:
        raise BenchError(f"the optimizer printed more than {PRINTED / 1e6:g} MB in one run") from error
    except (*FAILURES, LostError) as error:
        raise BenchError(f"the optimizer failed: {printable(str(error), LONGEST)}") from error
    if isinstance(answer, dict) and "error" in answer:
        raise BenchError(printable(str(answer["error"]), LONGEST))
    return answer
