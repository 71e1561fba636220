"""Compile a loop by numba, once for this machine."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any


@cache
def compiled(function: Callable[..., object], signature: str) -> Callable[..., Any]:
    """Return a function compiled for a numba signature, or loaded from numba's cache on disk.

    With ``NUMBA_DISABLE_JIT`` it is the function itself.
    """
    from numba import njit

    loop: Callable[..., Any]
    try:
        loop = njit([signature], cache=True)(function)
    except RuntimeError:  # no folder that numba could write to
        loop = njit([signature])(function)
    return loop
