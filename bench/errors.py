"""The one exception a user of the harness sees for input that cannot be worked with."""

from collections.abc import Iterable
from difflib import get_close_matches


class BenchError(ValueError):
    """Bad input: the message is one sentence that says what was wrong, where, and what to do.

    The command line prints it without a traceback and exits with code 2.
    """


def nearest(name: str, known: Iterable[str]) -> str:
    """Return a hint such as ``"; did you mean 'gwo'?"`` or, with nothing near, the list of what is known."""
    known = sorted(known)
    close = get_close_matches(name, known, n=1, cutoff=0.5)
    if close:
        return f"; did you mean {close[0]!r}?"
    if not known:
        return "; there are none"
    shown = ", ".join(known[:12])
    return f"; known: {shown}{', …' if len(known) > 12 else ''}"
