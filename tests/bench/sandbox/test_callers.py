"""Calls side by side: groups share no process, an error costs one call, and nothing outlives the context."""

import os
import signal
import subprocess
import sys
import time
from threading import Thread

import psutil
import pytest

from bench.sandbox.callers import Call, Callers
from bench.sandbox.process import DiedError, LostError, PrintedTooMuchError, RemoteError, TimeExceededError
from tests.bench.sandbox.helpers import LONG, gone, hear_interrupts

HANGS = """
import time
from bench.sandbox.callers import Call, Callers
with Callers(JOBS, time.monotonic) as callers:
    answers = callers.answers([Call(0, time.sleep, (600,)) for _ in range(5)])
    print("begun", flush=True)
    next(answers)
"""


@pytest.fixture
def callers():
    with Callers(1, os.getpid) as callers:
        yield callers


def answers(callers, *calls):
    return [answer for _, answer in callers.answers(calls)]


def test_a_group_s_calls_share_a_process_and_no_other_group_s_run_in_it(callers):
    pids = answers(callers, *(Call(group, os.getpid) for group in ("a", "a", "b", "a")))
    assert pids[0] == pids[1]
    assert len({os.getpid(), *pids}) == 4


def test_calls_are_made_side_by_side_and_answered_in_their_order(tmp_path):
    waits = f"while [ ! -e {tmp_path}/second ]; do sleep 0.01; done"
    with Callers(2, os.getpid) as callers:
        calls = Call(0, os.system, (waits,)), Call(0, os.system, (f"touch {tmp_path}/second; exit 1",))
        assert answers(callers, *calls) == [0, 256]


def test_an_error_costs_its_own_call_alone(callers):
    found = answers(
        callers, Call(0, os._exit, (3,)), Call(0, int, ("x",)), Call(0, os.write, (1, b"xxx"), {"printed": 2}),
        Call(0, time.sleep, (600,), {"seconds": 0.2}), Call(0, len, ("abc",)),
    )  # fmt: skip
    assert [*map(type, found[:-1])] == [DiedError, RemoteError, PrintedTooMuchError, TimeExceededError]
    assert found[-1] == 3


def test_what_is_not_wanted_any_more_is_not_called(callers):
    assert answers(callers, Call(0, os._exit, (3,), wanted=lambda: False), Call(0, len, ("abc",))) == [None, 3]


def test_the_end_of_the_context_ends_what_runs():
    found = []
    with Callers(1, os.getpid) as callers:
        pid = callers.answer(Call(0, os.getpid))[1]
        thread = Thread(target=lambda: found.append(callers.answer(Call(0, time.sleep, (600,)))[1]))
        thread.start()
        while callers._idle:
            time.sleep(0.01)
    thread.join(LONG)
    assert isinstance(found[0], (DiedError, LostError))
    assert gone(pid)


@pytest.mark.parametrize("jobs", [1, 2])
@pytest.mark.skipif(not hasattr(os, "killpg"), reason="a terminal's interrupt is sent to a process group")
def test_an_interrupt_ends_it_at_once_without_a_word_from_its_processes(jobs):
    command = [sys.executable, "-c", HANGS.replace("JOBS", str(jobs))]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, start_new_session=True, preexec_fn=hear_interrupts, **pipes) as parent:
        assert parent.stdout.readline() == "begun\n"
        until = time.monotonic() + LONG
        while (
            len(others := psutil.Process(parent.pid).children(recursive=True)) < 2 * jobs and time.monotonic() < until
        ):
            time.sleep(0.01)
        os.killpg(parent.pid, signal.SIGINT)
        printed = parent.communicate(timeout=LONG)
    assert printed[0] == ""
    assert printed[1].count("Traceback") == 1  # the parent's own
    assert printed[1].endswith("KeyboardInterrupt\n")
    assert gone(*(each.pid for each in others))
