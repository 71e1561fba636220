"""Copies of a process: forked from it, or made again where processes do not fork."""

import os
import signal
from contextlib import suppress
from threading import Thread

import pytest

from bench.sandbox.channel import Channel
from bench.sandbox.process import (
    DiedError,
    LostError,
    MemoryExceededError,
    Process,
    RemoteError,
    TimeExceededError,
)
from bench.sandbox.server import FORKS
from tests.bench.sandbox.helpers import LINUX, LONG, gone, of_call, running, wait_for, written


@pytest.fixture(params=[True, False], ids=["forked", "made again"])
def forks(request, monkeypatch):
    """Whether copies are forked; elsewhere they are new processes in which the same calls are made."""
    if request.param and not FORKS:
        pytest.skip("processes do not fork here")
    monkeypatch.setattr("bench.sandbox.process.FORKS", request.param)
    return request.param


def number(calls, process):
    return process.call(calls.evaluate, "os.getpid()", seconds=LONG)


def test_copies_hold_what_was_loaded_and_share_no_change(calls, template, forks):
    assert template.call(calls.load, "one", seconds=LONG) == ["one"]
    with template.fork() as first, template.fork() as second:
        assert first.call(calls.load, "two", seconds=LONG) == ["one", "two"]
        assert second.call(calls.load, "three", seconds=LONG) == ["one", "three"]
        with first.fork() as third:
            assert third.call(calls.load, "four", seconds=LONG) == ["one", "two", "four"]
        assert template.call(calls.load, "five", seconds=LONG) == ["one", "five"]
        assert len({number(calls, each) for each in (template, first, second)}) == 3
        parents = [each.call(calls.evaluate, "os.getppid()", seconds=LONG) for each in (first, second)]
        assert parents == [number(calls, template) if forks else os.getpid()] * 2


def test_a_call_that_raised_is_not_made_again(calls, template, forks):
    with pytest.raises(RemoteError):
        template.call(calls.evaluate, "loaded.append(1) or 1 / 0", seconds=LONG)
    with template.fork() as copy:
        assert copy.call(calls.evaluate, "loaded", seconds=LONG) == ([1] if forks else [])


def test_a_copy_has_an_output_and_a_session_of_its_own(calls, template, forks):
    with template.fork() as copy:
        copy.call(calls.evaluate, "os.write(2, b'much')", seconds=LONG)
        assert wait_for(lambda: copy.printed == 4)
        assert template.printed == 0
        session, pid = copy.call(calls.evaluate, "(os.getsid(0), os.getpid())", seconds=LONG)
        assert session == pid


@pytest.mark.parametrize("exit_code", [0, 3])
def test_a_copy_that_ends_costs_no_other(calls, template, forks, exit_code):
    with template.fork() as first, template.fork() as second:
        with pytest.raises(DiedError) as caught:
            first.call(calls.leave, exit_code, b"the reason", seconds=LONG)
        assert (caught.value.code, caught.value.end_of_output) == (exit_code, "the reason")
        assert second.call(calls.echo, seconds=LONG) == []
        with template.fork() as third:
            assert third.call(calls.echo, seconds=LONG) == []


def test_a_crash_and_a_limit_of_a_copy_are_reported_as_its_own(calls, template, forks):
    with pytest.raises(DiedError, match="signal SIGSEGV"):
        template.fork().call(calls.crash, seconds=LONG)
    with pytest.raises(MemoryExceededError):
        template.fork().call(calls.hog, 600, seconds=LONG, memory=300_000_000)
    with pytest.raises(TimeExceededError):
        template.fork().call(calls.sleep, LONG, seconds=0.2)
    assert template.call(calls.echo, seconds=LONG) == []


@LINUX
@pytest.mark.parametrize("end", ["close", "die"])
def test_what_a_copy_started_ends_with_it_and_nothing_else_does(calls, template, end):
    with template.fork() as kept:
        others = kept.call(calls.start_others, seconds=LONG)
        copy = template.fork()
        strays = copy.call(calls.start_others, seconds=LONG)
        assert all(map(running, [*others, *strays]))
        if end == "close":
            copy.close()
        else:
            with pytest.raises(DiedError):
                copy.call(calls.leave, 3, b"", seconds=LONG)
        assert gone(*strays)
        assert all(map(running, others))


def test_copies_end_when_another_thread_kills_the_first_of_their_templates(calls, template, forks):
    first = template.fork()
    second = first.fork()
    pids = [number(calls, each) for each in (first, second)]
    Thread(target=lambda: wait_for(lambda: second._begun[0] is calls.sleep) and template.kill()).start()
    with pytest.raises((DiedError, LostError)):
        second.call(calls.sleep, 10 * LONG)
    assert gone(*pids)


@LINUX
@pytest.mark.parametrize("end", [Process.close, Process.kill, lambda template: os.kill(template._process.pid, 9)])
def test_copies_end_with_their_template(calls, template, end):
    copies = [template.fork()]
    copies.append(copies[0].fork())
    pids = [number(calls, each) for each in copies]
    end(template)
    assert gone(*pids)
    for each in copies:
        with pytest.raises(LostError):
            each.call(calls.echo, seconds=LONG)
    with pytest.raises(LostError):
        template.fork()


@LINUX
def test_a_template_that_is_killed_in_mid_call_of_its_copy_is_lost(calls, template, tmp_path):
    path = tmp_path / "pid"
    copy = template.fork()
    Thread(target=lambda: written(path) and os.kill(template._process.pid, signal.SIGKILL)).start()
    with pytest.raises(LostError):
        copy.call(calls.hang_in_native_code, str(path), seconds=LONG)
    assert gone(*written(path))


@LINUX
def test_a_template_that_is_stopped_is_given_up(calls, template, monkeypatch):
    copy = template.fork()
    pid = number(calls, copy)
    monkeypatch.setattr("bench.sandbox.process._ANSWER", 0.5)
    os.kill(template._process.pid, signal.SIGSTOP)
    assert copy.call(calls.echo, seconds=LONG) == []  # which needs no template
    with pytest.raises(LostError):
        template.fork()
    copy.close()  # it has ended with its template
    with pytest.raises(LostError):
        copy.call(calls.echo)
    assert gone(pid, template._process.pid)


def test_the_files_of_copies_are_closed_with_their_template(template, forks):
    copies = [template.fork()]
    copies.append(copies[0].fork())
    template.close()
    for each in copies:
        assert each._output.closed
        assert each._channel.fileno() == -1


@LINUX
def test_templates_that_are_all_stopped_are_waited_for_once(calls, template, monkeypatch):
    waited = []
    receive = Channel.receive

    def count(self, seconds=None):
        message = receive(self, seconds)
        waited.extend([seconds] * (message is None))
        return message

    first = template.fork()
    second = first.fork()
    monkeypatch.setattr("bench.sandbox.process._ANSWER", 0.53)
    monkeypatch.setattr(Channel, "receive", count)
    for each in (first._pid, template._process.pid):
        os.kill(each, signal.SIGSTOP)
    with pytest.raises(LostError):
        second.call(calls.leave, 3, b"", seconds=LONG)
    for each in (second, first):
        with suppress(LostError):
            each.close()
    assert waited.count(0.53) <= 2  # its own template, and that one's


@LINUX
def test_a_template_in_which_plug_in_code_answers_is_ended(calls, template):
    first, other = template.fork(), template.fork()
    assert first.call(calls.send, of_call(5), seconds=LONG) == 5
    with pytest.raises(RemoteError, match="it sent what answers no call"):
        first.fork()
    assert first.closed
    assert not other.closed
    assert other.call(calls.echo, seconds=LONG) == []


@LINUX
def test_a_stopped_template_hides_no_time_limit_of_its_copy(calls, template, monkeypatch):
    copy = template.fork()
    monkeypatch.setattr("bench.sandbox.process._ANSWER", 0.5)
    os.kill(template._process.pid, signal.SIGSTOP)
    with pytest.raises(LostError):
        copy.call(calls.sleep, 10 * LONG, seconds=LONG)  # it is looked at before that


@LINUX
def test_a_template_with_threads_is_not_forked(calls, template):
    template.call(calls.load, "one", seconds=LONG)
    template.call(calls.start_threads, 2, seconds=LONG)
    with template.fork() as copy:
        assert copy.call(calls.evaluate, "os.getppid()", seconds=LONG) == os.getpid()
        assert copy.call(calls.evaluate, "loaded, threading.active_count() >= 3", seconds=LONG) == [["one"], True]


def test_calls_that_are_made_again_have_the_limits_that_they_had(calls, template, tmp_path, monkeypatch):
    monkeypatch.setattr("bench.sandbox.process.FORKS", False)
    template.call(calls.load_once, "one", str(tmp_path / "called"), seconds=1.0)
    with pytest.raises(TimeExceededError, match=r"^1 s$"):
        template.fork()


def test_calls_that_change_nothing_are_not_kept_to_be_made_again(calls, template, monkeypatch):
    monkeypatch.setattr("bench.sandbox.process.FORKS", False)
    template.call(calls.load, "one", seconds=LONG)
    template.call(calls.load, "two", seconds=LONG, again=False)
    with template.fork() as copy:
        assert copy.call(calls.evaluate, "loaded", seconds=LONG) == ["one"]
