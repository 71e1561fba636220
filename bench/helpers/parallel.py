"""Call a function on many things side by side, by joblib's threads."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Generator, Iterable
from typing import Literal, TypeVar

from joblib import Parallel, delayed

Item = TypeVar("Item")
Found = TypeVar("Found")


def side_by_side(
    function: Callable[[Item], Found],
    items: Iterable[Item],
    n_jobs: int,
    *,
    in_order: bool = True,
    end: Callable[[], object] = lambda: None,
) -> Generator[Found]:
    """Return what a function returns for each item; the calls, which begin now, work in processes of their own.

    Items are taken as calls begin, by any thread, at most twice as many as jobs ahead. A call that raises ends all.

    Args:
        function: called in a thread for each job; for a single job in this one, when its value is asked for.
        items: what it is called with.
        n_jobs: calls at a time; -1 takes every core.
        in_order: whether to yield in the order of the items; otherwise as calls end.
        end: has the calls under way end, where the caller takes no more or is interrupted.
    """
    order: Literal["generator", "generator_unordered"] = "generator" if in_order else "generator_unordered"
    made = Parallel(n_jobs=n_jobs, backend="threading", return_as=order)(delayed(function)(item) for item in items)
    return _ended(made, end)


def _ended(made: Generator[Found], end: Callable[[], object]) -> Generator[Found]:
    try:
        for each in made:  # noqa: UP028 - "yield from" would wait for the calls under way before they are ended
            yield each
    except BaseException:
        end()
        raise
    finally:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # that calls have been cancelled
            made.close()
