"""What is told of a stranger's failure: in few words, whatever they hold."""

from __future__ import annotations

import re

from bench.text import printable

_LONGEST = 300  # characters of an exception
_LAST = 1000  # characters of what a process wrote before its end
_FRAMES = 3

_CRASH = re.compile(r"^Fatal Python error: .*$", re.MULTILINE)
_FRAME = re.compile(r'^  File ".*$', re.MULTILINE)


def describe_error(error: BaseException) -> str:
    """Return an exception as one printable line of about 300 characters: its type, and what it says."""
    try:
        said = (str(error)[: 10 * _LONGEST].strip() or "no message").splitlines()[0]
    except BaseException as another:  # __str__ is a stranger's code too
        said = f"its message cannot be told: {type(another).__name__}"
    return printable(f"{type(error).__name__}: {said}".replace("\n", " "), _LONGEST)


def end_of_output(written: bytes) -> str:
    """Return the useful end of what a process wrote to its standard error: of a crash, its kind and place.

    The place is what :mod:`faulthandler` tells of the thread that crashed, cut to its innermost frames.
    """
    text = printable(written.decode("utf-8", errors="replace").replace("\r", ""), len(written))
    crashes = list(_CRASH.finditer(text))
    if crashes:
        before = text[: crashes[-1].start()].rstrip("\n").rpartition("\n")[2]  # the C library may have said why
        frames = _FRAME.findall(text, crashes[-1].end())[:_FRAMES]
        return "\n".join(line[:_LONGEST] for line in (before, crashes[-1].group(), *frames) if line)
    text = text.strip()
    if len(text) <= _LAST:
        return text
    return text[-_LAST:].partition("\n")[2] or text[-_LAST:]
