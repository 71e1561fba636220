"""Turn plug-in exceptions and crash output into short, printable messages."""

from __future__ import annotations

import re

from bench.helpers.errors import typed
from bench.helpers.text import printable

_LONGEST = 300  # characters of an exception's line
_LAST = 1000  # characters kept of the output of a process that ended
_FRAMES = 3

_CRASH = re.compile(r"^Fatal Python error: .*$", re.MULTILINE)
_FRAME = re.compile(r'^  File ".*$', re.MULTILINE)


def describe_error(error: BaseException) -> str:
    """Return an exception as one printable line of about 300 characters: its type and message."""
    return printable(typed(error).replace("\n", " "), _LONGEST)


def end_of_output(written: bytes) -> str:
    """Return the end of what a process wrote to standard error; after a crash, the kind and place of the crash.

    The place is the innermost frames that :mod:`faulthandler` printed of the thread that crashed.
    """
    text = printable(written.decode("utf-8", errors="replace").replace("\r", ""), len(written))
    crashes = list(_CRASH.finditer(text))
    if crashes:
        # The C library may have printed the reason before.
        before = text[: crashes[-1].start()].rstrip("\n").rpartition("\n")[2]
        frames = _FRAME.findall(text, crashes[-1].end())[:_FRAMES]
        return "\n".join(line[:_LONGEST] for line in (before, crashes[-1].group(), *frames) if line)
    text = text.strip()
    last = text[-_LAST:]
    return last if last == text else last.partition("\n")[2] or last
