"""Compile an optimizer's inner loops with numba, at their first call."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, update_wrapper
from typing import Any, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., object])


def compiled(function: Function) -> Function:
    """Return ``function`` compiled by numba, with numpy's rules of division.

    numba is imported, and the function compiled or read from numba's cache on disk, when it is first called: importing
    an optimizer, as ``bench list`` does, must not wait for numba. Another compiled function may call it.

    Without ``fastmath``, no sum is reordered: results depend on the seed and not on the width of the CPU's vectors.
    """
    return cast(Function, _Compiled(function))


class _Compiled:
    """A function that numba compiles when it is first needed."""

    def __init__(self, function: Callable[..., object]) -> None:
        update_wrapper(self, function)
        self.function = function

    def __call__(self, *args: Any) -> Any:
        return self.dispatcher(*args)

    @cached_property
    def dispatcher(self) -> Any:
        from numba import njit

        return njit(self.function, cache=True, error_model="numpy")

    @property
    def _numba_type_(self) -> Any:
        """What numba takes this for where another compiled function calls it."""
        return self.dispatcher._numba_type_
