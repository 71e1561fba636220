"""A process and all that it started: which they are, how much memory they hold, and their end."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import psutil


def children() -> set[int]:
    """Return the numbers of this process's children, ended ones included."""
    numbers: set[int] = set()
    try:
        for task in Path("/proc/self/task").iterdir():
            numbers |= set(map(int, (task / "children").read_text().split()))
    except (OSError, ValueError):  # no Linux, or a kernel without this list
        with suppress(psutil.Error):
            numbers = {child.pid for child in psutil.Process().children()}
    return numbers


MANY = 1200
"""The processes that one may start: more are the work of a fork without end."""


def look(pid: int) -> int | None:
    """Return the bytes of memory that a process and its descendants hold, -1 where these are more than ``MANY``.

    Shared memory counts for each. None stands for a process that has ended.
    """
    held = 0
    try:
        first = psutil.Process(pid)
        if first.status() == psutil.STATUS_ZOMBIE:
            return None
        members = [first, *first.children(recursive=True)]
    except psutil.Error:
        return None
    if len(members) > MANY:
        return -1
    for member in members:
        with suppress(psutil.Error):
            held += member.memory_info().rss
    return held


def kill(pid: int) -> None:
    """End a process and its descendants, but never those of the whole system."""
    with suppress(psutil.Error):
        if pid <= 1:
            return
        first = psutil.Process(pid)
        for member in [*first.children(recursive=True), first]:
            with suppress(psutil.Error):
                member.kill()
