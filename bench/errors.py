"""The one exception for bad input, and helpers for its messages."""

from collections.abc import Iterable
from difflib import get_close_matches
from importlib import import_module
from typing import Any


class BenchError(ValueError):
    """Bad input: the message is one sentence that says what was wrong, where, and what to do.

    The command line prints it without a traceback and exits with code 2.
    """


def require(module: str, extra: str, needed: str) -> Any:
    """Import and return a module that an extra of this package installs.

    Args:
        module: its name, such as "pyarrow".
        extra: the extra of this package that installs it.
        needed: the start of the message where the module is missing, such as "the parquet format needs".

    Raises:
        BenchError: where it is not installed.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name not in (module, module.partition(".")[0]):
            raise
        raise BenchError(f"{needed} {module}; install it with: pip install 'backlash-bench[{extra}]'") from error


def nearest(name: str, known: Iterable[str]) -> str:
    """Return a hint such as ``"; did you mean 'gwo'?"`` or, where none is near, the list of known names."""
    known = sorted(known)
    close = get_close_matches(name, known, n=1, cutoff=0.5)
    if close:
        return f"; did you mean {close[0]!r}?"
    if not known:
        return "; there are none"
    shown = ", ".join(known[:12])
    return f"; known: {shown}{', …' if len(known) > 12 else ''}"
