"""What the tests of processes share."""

import signal
import sys
import time
from contextlib import suppress

import psutil
import pytest

LONG = 120.0  # seconds; ends a test that hangs, and decides nothing else
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="what Linux alone offers")


def hear_interrupts():
    """Undo in a new process what a shell does to its background jobs, of which these tests may be one."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def gone(*pids):
    """Whether all these have ended, now or soon."""
    return wait_for(lambda: not any(map(running, pids)))


def running(pid):
    with suppress(psutil.NoSuchProcess):
        return psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
    return False


def written(path):
    """The numbers in a file that a process writes sooner or later."""
    wait_for(lambda: path.exists() and path.read_text().endswith("\n"))
    return [int(word) for word in path.read_text().split()]


def wait_for(condition):
    """Wait until the condition holds; return whether it does."""
    end = time.monotonic() + LONG
    while not (found := condition()) and time.monotonic() < end:
        time.sleep(0.02)
    return found


def of_call(number):
    return f'["value", {number}]'.encode()
