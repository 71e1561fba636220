"""A process for plug-in code: whatever that does, its owner gets an error and goes on, and nothing is left behind."""

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from importlib import import_module
from textwrap import dedent
from threading import Thread
from types import SimpleNamespace

import psutil
import pytest

from bench.sandbox.messages import describe_error, end_of_output
from bench.sandbox.process import DiedError, MemoryExceededError, Process, RemoteError, SilentError

LONG = 60.0  # seconds; ends a test that hangs, and decides nothing else
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="what Linux alone offers")


@pytest.fixture(scope="module")
def calls(testing_plugins):
    """What the processes are asked for: a module that they find too."""
    return import_module("testing_calls")


@pytest.fixture(scope="module")
def shared():
    """For calls that leave their process as it was."""
    with Process(hash_seed=0) as process:
        yield process


@pytest.fixture
def process():
    """For calls that end it."""
    with Process(hash_seed=0) as process:
        yield process


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


@pytest.fixture
def clock(monkeypatch):
    """The clock by which patience is measured; it stands still unless a test moves it."""
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr("bench.sandbox.process.monotonic", lambda: clock.now)
    return clock


# Answers


def test_a_call_returns_what_the_function_does(calls, shared):
    assert shared.call(calls.echo, 1, "two", patience=LONG) == (1, "two")
    assert shared.alive


def test_any_thread_may_call(calls, shared):
    answers = []
    thread = Thread(target=lambda: answers.append(shared.call(calls.echo, 3, patience=LONG)))
    thread.start()
    thread.join()
    assert answers == [(3,)]


def test_large_arguments_and_answers_pass(calls, shared):
    large = b"x" * 3_000_000
    assert shared.call(calls.echo, large, patience=LONG) == (large,)


@pytest.mark.parametrize(
    ("error", "said"),
    [
        ("ValueError('by zero')", "ValueError: by zero"),
        ("ValueError()", "ValueError: no message"),
        ("KeyboardInterrupt()", "KeyboardInterrupt: no message"),
        ("GeneratorExit()", "GeneratorExit: no message"),
        ("SystemExit(4)", "SystemExit: 4"),
        ("RaisingError()", "RaisingError: its message cannot be read: ValueError"),
        ("ColouredError()", "ColouredError: �[31mred� end"),
    ],
)
def test_what_the_function_raises_is_one_line(calls, shared, error, said):
    with pytest.raises(RemoteError) as caught:
        shared.call(calls.raise_, error, patience=LONG)
    assert str(caught.value) == said
    assert shared.call(calls.echo, patience=LONG) == ()


def test_a_message_of_megabytes_is_cut():
    said = describe_error(ValueError("much " * 1_000_000))
    assert said.startswith("ValueError: much much")
    assert len(said) == 301


@pytest.mark.parametrize(
    ("expression", "said"),
    [("lambda: 0", "pickle"), ("Reluctant()", "its answer cannot be read: ValueError: invalid literal")],
)
def test_an_answer_that_cannot_be_sent_or_read_is_an_error(calls, shared, expression, said):
    with pytest.raises(RemoteError, match=said):
        shared.call(calls.evaluate, expression, patience=LONG)
    assert shared.call(calls.echo, patience=LONG) == ()


def test_the_answer_to_a_call_that_was_interrupted_is_not_the_next_one_s(calls, shared, tmp_path):
    def interrupt(made, budget):
        (tmp_path / "enough").touch()
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        shared.call(calls.work, str(tmp_path / "enough"), patience=LONG, on_pulse=interrupt)
    assert shared.call(calls.echo, "mine", patience=LONG) == ("mine",)


def test_a_fork_that_comes_back_from_its_call_answers_nobody(calls, shared):
    pulses = []
    assert shared.call(calls.fork, patience=LONG, on_pulse=lambda *pulse: pulses.append(pulse)) == 0
    assert shared.call(calls.echo, "mine", patience=LONG) == ("mine",)
    assert pulses == []


# What is around the function


def test_numerical_libraries_find_one_core(calls, shared):
    names = ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "NUMBA", "BLIS")
    asked = f"[os.environ[f'{{name}}_NUM_THREADS'] for name in {names}] + [os.environ['VECLIB_MAXIMUM_THREADS']]"
    assert shared.call(calls.evaluate, asked, patience=LONG) == ["1"] * 7


def test_keys_of_the_terminal_do_not_reach_it(calls, shared):
    session, pid = shared.call(calls.evaluate, "(os.getsid(0), os.getpid())", patience=LONG)
    assert session == pid


@LINUX
def test_the_kernel_ends_it_first_where_memory_is_short(calls, shared):
    assert shared.call(calls.evaluate, "Path('/proc/self/oom_score_adj').read_text()", patience=LONG) == "1000\n"


def test_prints_block_nobody_and_are_not_kept(calls, process):
    assert process.call(calls.print_much, 100, patience=LONG) == "done"
    with pytest.raises(DiedError) as caught:
        process.call(calls.leave, 3, b"x" * 1_000_000 + b"\nthe end\n", patience=LONG)
    assert caught.value.end_of_output.endswith("the end")
    assert len(caught.value.end_of_output) <= 1000


# Its end


def test_one_that_hangs_is_ended_after_the_patience(calls, process, clock):
    def pass_time(made, budget):
        clock.now += 0.7

    with pytest.raises(SilentError, match=r"0\.7 s"):
        process.call(calls.sleep, 10 * LONG, patience=0.7, on_pulse=pass_time)
    assert process.pulse == (1, 2)
    assert not process.alive


def test_pulses_are_signs_of_life(calls, shared, clock, tmp_path):
    pulses = []

    def pass_time(*pulse):
        clock.now += 1.0
        pulses.append(pulse)
        if len(pulses) == 4:
            (tmp_path / "enough").touch()

    sent = shared.call(calls.work, str(tmp_path / "enough"), patience=1.5, on_pulse=pass_time)
    assert 4 <= len(pulses) < sent / 10  # most of them are kept back
    assert shared.pulse == (1, 2)


def test_one_that_does_not_read_its_call_holds_nobody_up(calls, process):
    pid = process.call(calls.evaluate, "os.getpid()", patience=LONG)
    os.kill(pid, signal.SIGSTOP)
    with pytest.raises(SilentError):
        process.call(calls.echo, b"x" * 3_000_000, patience=0.5)
    assert gone(pid)


def test_a_crash_gives_its_place(calls, process):
    with pytest.raises(DiedError) as caught:
        process.call(calls.crash, patience=LONG)
    assert caught.value.code == -signal.SIGSEGV
    assert str(caught.value) == "signal SIGSEGV"
    lines = caught.value.end_of_output.splitlines()
    assert lines[0] == "Fatal Python error: Segmentation fault"
    assert "in string_at" in lines[1]
    assert "in crash" in lines[2]
    assert len(lines) == 4


def test_an_exit_gives_its_code_and_last_output(calls, process):
    with pytest.raises(DiedError) as caught:
        process.call(calls.leave, 3, b"\x1b[31mno licence\x00\xff\n", patience=None)
    assert (caught.value.code, str(caught.value)) == (3, "exit code 3")
    assert caught.value.end_of_output == "�[31mno licence��"
    assert not process.alive
    with pytest.raises(DiedError):
        process.call(calls.echo, patience=LONG)


def test_the_end_of_output_is_that_of_the_call(calls, process):
    assert process.call(calls.evaluate, "os.write(2, b'a warning')", patience=LONG) == 9
    assert wait_for(lambda: process.printed == 9)
    process.call(calls.echo, patience=LONG)
    with pytest.raises(DiedError) as caught:
        process.call(calls.leave, 3, b"", patience=LONG)
    assert caught.value.end_of_output == ""


def test_one_that_closes_its_pipes_is_ended(calls, process):
    with pytest.raises(DiedError):
        process.call(calls.lose_pipes, patience=LONG)
    assert not process.alive


@pytest.mark.parametrize("own_session", [False, True])
def test_an_end_is_noticed_though_a_fork_keeps_the_pipes_open(calls, process, tmp_path, own_session):
    path = tmp_path / "pid"
    try:
        with pytest.raises(DiedError) as caught:
            process.call(calls.fork_and_leave, str(path), own_session, str(path), patience=LONG)
        assert caught.value.code == 3
        assert own_session or gone(*written(path))
    finally:
        with suppress(OSError):
            os.kill(written(path)[0], signal.SIGKILL)


def test_a_child_that_was_seen_is_ended_though_its_parent_died_first(calls, process, tmp_path):
    path, seen = tmp_path / "pid", tmp_path / "seen"

    def look():
        (child,) = written(path)
        if wait_for(lambda: child in {member.pid for member in tuple(process._tree._members)}):
            seen.touch()

    Thread(target=look).start()
    with pytest.raises(DiedError):
        process.call(calls.fork_and_leave, str(path), True, str(seen), patience=LONG, memory=10**12)
    assert gone(*written(path))


@pytest.mark.parametrize("function", ["hog", "have_a_child_hog"])
def test_one_that_takes_too_much_memory_is_ended(calls, process, function):
    with pytest.raises(MemoryExceededError, match=r"it held .* MB of memory, where 300 MB are allowed"):
        process.call(getattr(calls, function), 600, patience=LONG, memory=300_000_000)
    assert not process.alive


def test_the_memory_that_it_holds_is_known(calls, shared):
    assert 10e6 < shared.resident < 1e9


@LINUX
def test_what_it_started_ends_with_it(calls, process):
    others = process.call(calls.start_others, patience=LONG)
    assert all(map(running, others))
    process.close()
    assert gone(*others)
    process.close()


@LINUX
def test_it_ends_in_the_middle_of_a_call_when_its_owner_is_killed(tmp_path):
    """One of the processes keeps its interpreter locked, the other one was started by no main thread."""
    script = dedent(
        f"""
        from threading import Thread
        from bench.sandbox.process import Process
        from testing_calls import hang_in_native_code, hang_with_a_child

        def call(process, function, path):
            process.call(function, path, patience=None)

        native = Process(0)
        Thread(target=call, args=(native, hang_in_native_code, {str(tmp_path / "native")!r})).start()
        Thread(target=lambda: call(Process(0), hang_with_a_child, {str(tmp_path / "child")!r})).start()
        """
    )
    owner = subprocess.Popen([sys.executable, "-c", script])
    pids = [*written(tmp_path / "native"), *written(tmp_path / "child")]
    try:
        assert len(pids) == 3
        assert all(map(running, pids))
        owner.kill()
        owner.wait()
        assert gone(*pids)
    finally:
        for pid in pids:
            with suppress(OSError):
                os.kill(pid, signal.SIGKILL)


# Words


def test_the_c_library_s_reason_of_a_crash_is_kept_too():
    said = b"warming up\nfree(): invalid pointer\nFatal Python error: Aborted\n\nStack (most recent call first):\n"
    said += b"".join(b'  File "mine.py", line %d in f\n' % line for line in range(9)) + b"\nExtension modules: numpy\n"
    assert end_of_output(said).splitlines() == [
        "free(): invalid pointer",
        "Fatal Python error: Aborted",
        *(f'  File "mine.py", line {line} in f' for line in range(3)),
    ]


def test_the_end_of_output_begins_with_a_whole_line():
    said = end_of_output(b"first\n" + b"a line of thirty characters...\n" * 100)
    assert set(said.splitlines()) == {"a line of thirty characters..."}
    assert 900 < len(said) <= 1000
