"""Calls side by side: groups share no process, an error costs one call, and nothing outlives the pool."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import CancelledError

import psutil
import pytest

from bench.sandbox.pool import Pool
from bench.sandbox.process import DiedError, PrintedTooMuchError, RemoteError, TimeExceededError
from tests.bench.sandbox.helpers import LONG, gone

HANGS = """
import time
from bench.sandbox.pool import Pool
with Pool(2, time.monotonic) as pool:
    begun = [pool.submit(0, time.sleep, 600) for _ in range(5)]
    print("begun", flush=True)
    begun[0].result()
"""


@pytest.fixture
def pool():
    with Pool(1, os.getpid) as pool:
        yield pool


def test_a_group_s_calls_share_a_process_and_no_other_group_s_run_in_it(pool):
    pids = [pool.submit(group, os.getpid).result(LONG) for group in ("a", "a", "b", "a")]
    assert pids[0] == pids[1]
    assert len({os.getpid(), *pids}) == 4


def test_calls_are_made_side_by_side_and_answered_in_any_order():
    with Pool(2, os.getpid) as pool:
        slow, quick = pool.submit(0, time.sleep, LONG), pool.submit(0, len, "abc")
        assert quick.result(LONG) == 3
        assert not slow.done()


def test_an_error_costs_its_own_call_alone(pool):
    begun = [
        pool.submit(0, os._exit, 3), pool.submit(0, int, "x"), pool.submit(0, os.write, 1, b"xxx", printed=2),
        pool.submit(0, len, "abc"),
    ]  # fmt: skip
    for each, error in zip(begun, (DiedError, RemoteError, PrintedTooMuchError), strict=False):
        with pytest.raises(error):
            each.result(LONG)
    assert begun[-1].result(LONG) == 3


def test_closing_ends_what_runs_and_cancels_what_has_not_begun():
    with Pool(1, os.getpid) as pool:
        pid = pool.submit(0, os.getpid).result(LONG)
        running_, waiting = pool.submit(0, time.sleep, 600), pool.submit(0, time.sleep, 600)
        while not running_.running():
            time.sleep(0.01)
    assert gone(pid)
    with pytest.raises(RuntimeError):
        running_.result(0)
    with pytest.raises(CancelledError):
        waiting.result(0)


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="a terminal's interrupt is sent to a process group")
def test_an_interrupt_ends_it_at_once_without_a_word_from_its_processes():
    command = [sys.executable, "-c", HANGS]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, start_new_session=True, **pipes) as parent:
        assert parent.stdout.readline() == "begun\n"
        until = time.monotonic() + LONG
        while len(others := psutil.Process(parent.pid).children(recursive=True)) < 4 and time.monotonic() < until:
            time.sleep(0.01)
        os.killpg(parent.pid, signal.SIGINT)
        printed = parent.communicate(timeout=LONG)
    assert printed[0] == ""
    assert printed[1].count("Traceback") == 1  # the parent's own
    assert printed[1].endswith("KeyboardInterrupt\n")
    assert gone(*(each.pid for each in others))


def test_a_call_that_takes_too_long_is_ended_and_costs_no_other():
    with Pool(1, os.getpid) as pool:
        slow, next_one = pool.submit(0, time.sleep, 600, seconds=0.2), pool.submit(0, os.getpid)
        with pytest.raises(TimeExceededError):
            slow.result(LONG)
        assert next_one.result(LONG) != os.getpid()
