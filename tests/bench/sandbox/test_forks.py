"""Fork servers: processes that have made the same calls, forked from one or started anew."""

import os
import signal
from threading import Thread

import pytest

from bench.sandbox.forks import ForkServer
from bench.sandbox.process import DiedError, LostError, Process, RemoteError, TimeExceededError
from bench.sandbox.server import FORKS
from tests.bench.sandbox.helpers import LINUX, LONG, gone, of_call, running, wait_for, written


@pytest.fixture(params=[True, False], ids=["forked", "started anew"])
def forks(request, monkeypatch):
    """Whether processes are forked."""
    if request.param and not FORKS:
        pytest.skip("processes do not fork here")
    monkeypatch.setattr("bench.sandbox.forks.FORKS", request.param)
    return request.param


@pytest.fixture
def server(forks):
    with ForkServer() as server:
        yield server


@pytest.fixture
def original():
    """A process that is there to be forked."""
    with Process(forks=True) as process:
        yield process


def number(calls, process):
    return process.call(calls.evaluate, "os.getpid()", seconds=LONG)


# Fork servers


def test_processes_and_branches_hold_what_was_loaded_and_share_no_change(calls, server):
    assert server.call(calls.load, "one", seconds=LONG) == ["one"]
    branch = server.branch()
    assert branch.call(calls.load, "two", seconds=LONG) == ["one", "two"]
    assert server.call(calls.load, "three", seconds=LONG) == ["one", "three"]
    with server.process() as first, branch.process() as second, branch.process() as third:
        assert first.call(calls.load, "x", seconds=LONG) == ["one", "three", "x"]
        assert second.call(calls.load, "y", seconds=LONG) == ["one", "two", "y"]
        assert third.call(calls.evaluate, "loaded", seconds=LONG) == ["one", "two"]
        assert len({number(calls, each) for each in (first, second, third)}) == 3


def test_a_call_that_failed_is_not_made_again(calls, server):
    server.call(calls.load, "one", seconds=LONG)
    with pytest.raises(RemoteError):
        server.call(calls.evaluate, "loaded.append(1) or 1 / 0", seconds=LONG)
    with pytest.raises(TimeExceededError):
        server.call(calls.sleep, LONG, seconds=0.2)
    with server.process() as process:
        assert process.call(calls.evaluate, "loaded", seconds=LONG) == ["one"]


@pytest.mark.slow
def test_calls_that_are_made_again_have_the_limits_that_they_had(calls, tmp_path, monkeypatch):
    monkeypatch.setattr("bench.sandbox.forks.FORKS", False)
    with ForkServer() as server:
        server.call(calls.load_once, "one", str(tmp_path / "called"), seconds=1.0)
        server.process().close()
        with pytest.raises(TimeExceededError, match=r"^1 s$"):
            server.process()


def test_a_process_has_an_output_and_a_session_of_its_own(calls, server):
    with server.process() as process:
        process.call(calls.evaluate, "os.write(2, b'much')", seconds=LONG)
        assert wait_for(lambda: process.printed == 4)
        session, pid = process.call(calls.evaluate, "(os.getsid(0), os.getpid())", seconds=LONG)
        assert session == pid


def test_all_end_when_another_thread_kills_the_server(calls, server, tmp_path):
    process = server.branch().process()
    pid = number(calls, process)
    path = tmp_path / "pid"
    Thread(target=lambda: written(path) and server.kill()).start()
    with pytest.raises((DiedError, LostError)):
        process.call(calls.hang_in_native_code, str(path), seconds=LONG)
    assert gone(pid)
    with pytest.raises(LostError):
        server.process()


@LINUX
def test_one_with_threads_is_not_forked(calls):
    with ForkServer() as server:
        server.call(calls.load, "one", seconds=LONG)
        server.call(calls.start_threads, 2, seconds=LONG)
        for _ in range(2):
            with server.process() as process:
                assert process.call(calls.evaluate, "os.getppid()", seconds=LONG) == os.getpid()
                assert process.call(calls.evaluate, "loaded, threading.active_count() >= 3", seconds=LONG) == [
                    ["one"], True
                ]  # fmt: skip


@LINUX
def test_a_server_whose_process_is_lost_starts_another(calls):
    with ForkServer() as server:
        server.call(calls.load, "one", seconds=LONG)
        branch = server.branch()
        server.close()
        with branch.process() as process:
            assert process.call(calls.evaluate, "loaded", seconds=LONG) == ["one"]


# Forks


@LINUX
@pytest.mark.parametrize("end", ["close", "die"])
def test_what_a_fork_started_ends_with_it_and_nothing_else_does(calls, original, end):
    with original.fork() as kept:
        others = kept.call(calls.start_others, seconds=LONG)
        fork = original.fork()
        strays = fork.call(calls.start_others, seconds=LONG)
        assert all(map(running, [*others, *strays]))
        if end == "close":
            fork.close()
        else:
            with pytest.raises(DiedError):
                fork.call(calls.leave, 3, b"", seconds=LONG)
        assert gone(*strays)
        assert all(map(running, others))


@LINUX
@pytest.mark.parametrize("end", [Process.close, Process.kill, lambda original: os.kill(original._process.pid, 9)])
def test_forks_end_with_their_original(calls, original, end):
    forks = [original.fork()]
    forks.append(forks[0].fork())
    pids = [number(calls, each) for each in forks]
    end(original)
    assert gone(*pids)
    for each in forks:
        with pytest.raises(LostError):
            each.call(calls.echo, seconds=LONG)
    with pytest.raises(LostError):
        original.fork()


@pytest.mark.sampled(1)
@LINUX
@pytest.mark.parametrize("limit", [None, LONG])
def test_a_fork_whose_original_answers_no_more_is_given_up_without_a_time_limit_too(
    calls, original, monkeypatch, limit
):
    other = original.fork()
    os.kill(original._process.pid, signal.SIGSTOP)
    monkeypatch.setattr("bench.sandbox.process._ANSWER", 0.5)  # from here on nothing answers, however long one waits
    with pytest.raises(LostError):
        other.call(calls.sleep, 10 * LONG, seconds=limit)  # it is looked at before that
    with pytest.raises(LostError):
        original.fork()
    assert original.closed
    assert other.closed


@LINUX
def test_one_in_which_plug_in_code_answers_is_ended(calls, original):
    first, other = original.fork(), original.fork()
    assert first.call(calls.send, of_call(5), seconds=LONG) == 5
    with pytest.raises(RemoteError, match="it sent what answers no call"):
        first.fork()
    assert first.closed
    assert not other.closed
    assert other.call(calls.echo, seconds=LONG) == []
