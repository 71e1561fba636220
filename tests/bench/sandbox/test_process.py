"""A process for plug-in code: whatever that does, its owner gets an error and goes on, and nothing is left behind."""

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from textwrap import dedent
from threading import Thread

import pytest

from bench.sandbox.messages import describe_error, end_of_output
from bench.sandbox.process import (
    DiedError,
    LostError,
    MemoryExceededError,
    PrintedTooMuchError,
    Process,
    RemoteError,
    TimeExceededError,
    TooManyProcessesError,
)
from tests.bench.sandbox.helpers import LINUX, LONG, gone, of_call, running, wait_for, written

# Starts


def test_a_process_imports_nothing_of_the_working_folder(calls, shadows):
    imports = "[__import__(name) and name for name in ('json', 'random')]"
    with Process() as process:
        assert process.call(calls.evaluate, imports, seconds=LONG) == ["json", "random"]
    assert not [*shadows.glob("*.imported")]


def test_a_folder_that_its_owner_has_added_shadows_nothing_that_is_installed(calls, shadows, monkeypatch):
    monkeypatch.syspath_prepend(shadows)
    imports = "__import__('random') and __import__('stride').STEP"
    with Process() as process:
        assert process.call(calls.evaluate, imports, seconds=LONG) == 0.1
    assert not [*shadows.glob("*.imported")]


@LINUX
@pytest.mark.parametrize("method", ["spawn", "forkserver"])
def test_a_process_that_plug_in_code_starts_imports_nothing_of_the_working_folder(calls, shadows, method):
    started = f"__import__('multiprocessing').get_context({method!r}).Pool(1).map(abs, [-1])"
    with Process() as process:
        assert process.call(calls.evaluate, started, seconds=LONG) == [1]
    assert not [*shadows.glob("*.imported")]


# Answers


def test_a_call_returns_what_the_function_does_as_json(calls, shared):
    assert shared.call(calls.echo, 1, "two", None, (0.1, float("inf")), seconds=LONG) == [
        1, "two", None, [0.1, float("inf")]
    ]  # fmt: skip
    assert not shared.closed


def test_large_arguments_and_answers_pass(calls, shared):
    large = "x" * 3_000_000
    assert shared.call(calls.echo, large, seconds=LONG) == [large]


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
        shared.call(calls.raise_, error, seconds=LONG)
    assert str(caught.value) == said
    assert shared.closed


def test_a_message_of_megabytes_is_cut():
    said = describe_error(ValueError("much " * 1_000_000))
    assert said.startswith("ValueError: much much")
    assert len(said) == 301


@pytest.mark.parametrize("expression", ["lambda: 0", "b'bytes'", "{(): 0}", "(a := [], a.append(a))", "1j"])
def test_an_answer_that_is_no_json_is_an_error(calls, shared, expression):
    with pytest.raises(RemoteError, match="its answer is no JSON: "):
        shared.call(calls.evaluate, expression, seconds=LONG)


def test_an_answer_too_long_is_an_error(calls, shared, monkeypatch):
    with pytest.raises(RemoteError, match="its answer is too long"):
        shared.call(calls.evaluate, "'x' * (1 << 26)", seconds=LONG)


def test_arguments_that_cannot_be_unpickled_are_an_error(calls, shared, monkeypatch):
    monkeypatch.setattr(calls.Bomb, "__reduce__", lambda self: (exec, ("raise OSError('on its way')",)))
    with pytest.raises(RemoteError, match="OSError: on its way"):
        shared.call(calls.echo, calls.Bomb(""), seconds=LONG)


def test_a_fork_that_comes_back_from_its_call_answers_nobody(calls, shared):
    assert shared.call(calls.fork, seconds=LONG) == 0
    assert shared.note is None
    assert shared.call(calls.echo, "mine", seconds=LONG) == ["mine"]


# Messages that plug-in code sends itself


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    "payload",
    [
        b"", b"\x80\x04.", b"no JSON", b'{"value": 5}', b"5", b'["value"]', b'["value", 5, 5]', b'["answer", 5]',
        b'[["value"], 5]', b'["value", 5', b'\xff\xfe["value", 5]', b"[" * 1_000_000,
        b'["value", ' + b"9" * 10_000 + b"]", b'{"a":' * 100_000,
        b'["value", [' + b"{}," * 20_000_000 + b"0]]",
    ],
    ids=lambda payload: repr(payload[:12]),
)  # fmt: skip
def test_what_is_no_message_ends_its_sender(calls, process, payload):
    with pytest.raises(RemoteError, match="it sent what answers no call"):
        process.call(calls.send, payload, seconds=LONG)
    assert process.closed


@pytest.mark.parametrize("ahead", [-1, 1, 2**40])
def test_an_answer_to_another_call_ends_its_sender(calls, process, ahead):
    process.call(calls.echo, seconds=LONG)
    with pytest.raises(RemoteError, match="it sent what answers no call"):
        process.call(calls.send, of_call(5), ahead, seconds=LONG)
    assert process.closed


def test_a_second_answer_is_not_the_next_call_s(calls, process):
    assert process.call(calls.send, of_call(5), seconds=LONG) == 5  # to be judged by whoever asked
    with pytest.raises(RemoteError, match="it sent what answers no call"):  # "honest", the call's own answer
        process.call(calls.echo, "mine", seconds=LONG)
    assert process.closed


def test_an_answer_is_never_unpickled(calls, process, tmp_path):
    mark = tmp_path / "unpickled"
    with pytest.raises(RemoteError, match="it sent what answers no call"):
        process.call(calls.send_bomb, str(mark), seconds=LONG)
    assert not mark.exists()


def test_one_that_announces_a_message_and_does_not_send_it_is_ended_in_time(calls, process):
    with pytest.raises(TimeExceededError):
        process.call(calls.send_head, 1 << 26, seconds=0.5)
    assert process.closed


def open_files():
    return len(list(Path("/proc/self/fd").iterdir()))


@LINUX
def test_files_that_come_with_a_message_are_not_kept(calls, process):
    before = open_files()
    process.call(calls.send_files, 100, seconds=LONG)
    assert open_files() < before + 50  # this process may open or close some of its own meanwhile


# What is around the function


def test_numerical_libraries_find_one_core(calls, shared):
    names = ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "NUMBA", "BLIS")
    asked = f"[os.environ[f'{{name}}_NUM_THREADS'] for name in {names}] + [os.environ['VECLIB_MAXIMUM_THREADS']]"
    assert shared.call(calls.evaluate, asked, seconds=LONG) == ["1"] * 7


@LINUX
def test_pandas_starts_no_thread_so_that_a_process_can_be_forked(calls):
    threads = "[each.joinpath('comm').read_text() for each in Path('/proc/self/task').iterdir()]"
    with Process(hash_seed=0, forks=True) as process:
        alone = process.call(calls.evaluate, threads, seconds=LONG)
        assert len(alone) == 1
        assert process.call(calls.evaluate, f"(__import__('pandas'), {threads})[1]", seconds=LONG) == alone


def test_keys_of_the_terminal_do_not_reach_it(calls, shared):
    session, pid = shared.call(calls.evaluate, "(os.getsid(0), os.getpid())", seconds=LONG)
    assert session == pid


@LINUX
def test_the_kernel_ends_it_first_where_memory_is_short(calls, shared):
    assert shared.call(calls.evaluate, "Path('/proc/self/oom_score_adj').read_text()", seconds=LONG) == "1000\n"


def test_prints_block_nobody_and_are_not_kept(calls, process):
    assert process.call(calls.print_much, 100, seconds=LONG) == "done"
    with pytest.raises(DiedError) as caught:
        process.call(calls.leave, 3, b"x" * 1_000_000 + b"\nthe end\n", seconds=LONG)
    assert caught.value.end_of_output.endswith("the end")
    assert len(caught.value.end_of_output) <= 1000


def test_one_that_prints_more_than_allowed_is_ended(calls, process):
    assert process.call(calls.print_much, 1, seconds=LONG, printed=10_000_000) == "done"
    with pytest.raises(PrintedTooMuchError):
        process.call(calls.print_much, 1, seconds=LONG, printed=1_000_000)
    assert process.closed


# Its end


def test_one_that_hangs_is_ended_after_its_time(calls, process):
    with pytest.raises(TimeExceededError, match=r"^0\.7 s$"):
        process.call(calls.sleep, 10 * LONG, seconds=0.7)
    assert process.closed


def test_notes_prolong_no_time_limit(calls, process, tmp_path):
    with pytest.raises(TimeExceededError, match=r"^0\.7 s$"):
        process.call(calls.work, str(tmp_path / "never"), seconds=0.7)
    assert process.closed


class Paused(Process):
    """A process whose owner is stopped for 1,000 seconds in the middle of its first wait."""

    def _set_up(self):
        end = super()._set_up()
        receive, stopped = self._channel.receive, iter([1000.0])

        def late(seconds):
            message = receive(seconds)
            Paused.now += seconds + next(stopped, 0.0)
            return message

        self._channel.receive = late
        return end


@pytest.fixture
def paused(monkeypatch):
    Paused.now = 0.0
    monkeypatch.setattr("bench.sandbox.process.monotonic", lambda: Paused.now)
    with Paused() as process:
        yield process


def test_the_time_for_which_all_processes_were_stopped_counts_against_no_limit(calls, paused, tmp_path):
    path = tmp_path / "enough"
    Thread(target=lambda: wait_for(lambda: Paused.now > 1001) and path.touch()).start()
    paused.call(calls.wait, str(path), seconds=60.0)
    assert Paused.now > 1000


def test_one_that_does_not_read_its_call_holds_nobody_up(calls, process, monkeypatch):
    monkeypatch.setattr("bench.sandbox.process._ANSWER", 0.2)
    pid = process.call(calls.evaluate, "os.getpid()", seconds=LONG)
    os.kill(pid, signal.SIGSTOP)
    with pytest.raises(DiedError):
        process.call(calls.echo, b"x" * 3_000_000, seconds=None)
    assert gone(pid)


def test_a_crash_gives_its_place(calls, process):
    with pytest.raises(DiedError) as caught:
        process.call(calls.crash, seconds=LONG)
    assert caught.value.code == -signal.SIGSEGV
    assert str(caught.value) == "signal SIGSEGV"
    lines = caught.value.end_of_output.splitlines()
    assert lines[0] == "Fatal Python error: Segmentation fault"
    assert "in string_at" in lines[1]
    assert "in crash" in lines[2]
    assert len(lines) == 4


def test_an_exit_gives_its_code_and_last_output(calls, process):
    with pytest.raises(DiedError) as caught:
        process.call(calls.leave, 3, b"\x1b[31mno licence\x00\xff\n", seconds=LONG)
    assert (caught.value.code, str(caught.value)) == (3, "exit code 3")
    assert caught.value.end_of_output == "�[31mno licence��"
    assert process.closed
    with pytest.raises(LostError):
        process.call(calls.echo, seconds=LONG)


def test_the_end_of_output_is_that_of_the_call(calls, process):
    assert process.call(calls.evaluate, "os.write(2, b'a warning')", seconds=LONG) == 9
    assert wait_for(lambda: process.printed == 9)
    process.call(calls.echo, seconds=LONG)
    with pytest.raises(DiedError) as caught:
        process.call(calls.leave, 3, b"", seconds=LONG)
    assert caught.value.end_of_output == ""


def test_one_that_closes_its_channel_is_ended(calls, process):
    with pytest.raises(DiedError):
        process.call(calls.lose_channel, seconds=LONG)
    assert process.closed


@pytest.mark.parametrize("own_session", [False, True])
def test_an_end_is_noticed_though_a_fork_keeps_the_channel_open(calls, process, tmp_path, own_session):
    path = tmp_path / "pid"
    try:
        with pytest.raises(DiedError) as caught:
            process.call(calls.fork_and_leave, str(path), own_session, seconds=LONG)
        assert caught.value.code == 3
        assert own_session or gone(*written(path))
    finally:
        with suppress(OSError):
            os.kill(written(path)[0], signal.SIGKILL)


@pytest.mark.parametrize("function", ["hog", "have_a_child_hog"])
def test_one_that_takes_too_much_memory_is_ended(calls, process, function):
    with pytest.raises(MemoryExceededError, match=r"it held .* MB of memory, where 300 MB are allowed"):
        process.call(getattr(calls, function), 600, seconds=LONG, memory=300_000_000)
    assert process.closed


def test_one_beside_it_that_takes_too_much_memory_is_ended(calls, process):
    with Process() as beside:
        beside.start(calls.hog, 600)
        process.start(calls.sleep, LONG)
        with pytest.raises(MemoryExceededError):
            process.finish(seconds=LONG, memory=300_000_000, beside=[beside])
        assert beside.closed
        assert not process.closed


@LINUX
def test_what_it_started_ends_with_it(calls, process):
    others = process.call(calls.start_others, seconds=LONG)
    assert all(map(running, others))
    process.close()
    assert gone(*others)
    process.close()


def test_any_thread_may_kill_it_in_mid_call(calls, process, tmp_path):
    path = tmp_path / "pid"
    Thread(target=lambda: written(path) and process.kill()).start()
    with pytest.raises(DiedError):
        process.call(calls.hang_in_native_code, str(path), seconds=LONG)


@LINUX
def test_it_ends_in_the_middle_of_a_call_when_its_owner_is_killed(tmp_path):
    """Of two copies, one keeps its interpreter locked and one has a child; another process was started by a thread."""
    script = dedent(
        f"""
        from threading import Thread
        from bench.sandbox.process import Process
        from testing_calls import hang_in_native_code, hang_with_a_child

        limit = {{"seconds": None}}
        originals = [Process(0, forks=True) for _ in range(2)]
        first, second = [each.fork() for each in originals]
        Thread(target=first.call, args=(hang_in_native_code, {str(tmp_path / "native")!r}), kwargs=limit).start()
        Thread(target=second.call, args=(hang_with_a_child, {str(tmp_path / "child")!r}), kwargs=limit).start()
        Thread(target=lambda: Process(0).call(hang_with_a_child, {str(tmp_path / "thread")!r}, **limit)).start()
        """
    )
    owner = subprocess.Popen([sys.executable, "-c", script])
    pids = [pid for name in ("native", "child", "thread") for pid in written(tmp_path / name)]
    try:
        assert len(pids) == 5
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


def test_a_process_that_starts_too_many_others_is_ended(monkeypatch):
    monkeypatch.setattr("bench.sandbox.tree.MANY", 3)
    with Process() as process, pytest.raises(TooManyProcessesError, match="more than 3 processes"):
        process.call(
            eval,
            "[__import__('subprocess').Popen(['sleep', '60']) for _ in range(5)] and __import__('time').sleep(60)",
            seconds=None,
        )
