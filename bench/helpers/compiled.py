"""Compile a loop by numba, once for this machine."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any


@cache
def compiled(function: Callable[..., Any], signature: Any) -> Callable[..., Any]:
    """Return a function compiled for a numba signature, or loaded from numba's cache on disk.

    It comes without numba's dispatcher: nothing checks the types of its arguments, and others than those of the
    signature would be misread. With ``NUMBA_DISABLE_JIT`` it is the function itself.
    """
    from numba import config, njit

    if config.DISABLE_JIT:
        return function
    try:
        dispatcher = njit([signature], cache=True)(function)
    except RuntimeError:  # no folder that numba could write to
        dispatcher = njit([signature])(function)
    made: Callable[..., Any] = dispatcher.get_overload(signature)
    return made
