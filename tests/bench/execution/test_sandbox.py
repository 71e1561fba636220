"""The sandbox: a stranger's optimizer can write nowhere, sees no other process and no network, and leaves nothing."""

import os
import shutil
from textwrap import dedent

import pandas as pd
import pytest

from bench import BenchError, load_results, run
from bench.execution.verify import verify
from bench.sandbox import bubblewrap
from bench.sandbox.process import Process

TIMES = ["wall_s", "cpu_s", "objective_s", "study"]


def reason():
    """Why no sandbox can be used here, "" where one can."""
    try:
        bubblewrap.command("bwrap")
    except BenchError as error:
        return str(error)
    return ""


REASON = reason()
needed = pytest.mark.skipif(bool(REASON), reason=REASON or "bubblewrap can be used")

ATTACKS = """
    import glob, os, signal, socket, sqlite3
    from pathlib import Path

    def _search(objective, rng):
        while True:
            objective(objective.initial(4))

    def honest(objective, rng):
        _search(objective, rng)

    def edits(objective, rng):
        with sqlite3.connect({store!r}) as connection:
            connection.execute("UPDATE results SET fun = 0")

    def writes(objective, rng):
        Path({folder!r}, "mark").write_text("here")

    def connects(objective, rng):
        socket.create_connection(("127.0.0.1", {port}), timeout=2)

    def kills(objective, rng):
        others = [int(each.name) for each in Path("/proc").iterdir() if each.name.isdigit()]
        if {parent} in others and b"pytest" in Path("/proc/{parent}/cmdline").read_bytes():
            raise AssertionError("it sees the process that runs the study")
        try:
            os.kill(-1, signal.SIGKILL)
        except ProcessLookupError:
            pass
        _search(objective, rng)

    def rewrites(objective, rng):
        for each in Path("/proc").iterdir():  # its template holds the problem that the next trial is given
            if each.name.isdigit() and int(each.name) not in (1, os.getpid()):
                try:
                    (each / "mem").open("r+b").close()
                except PermissionError:
                    continue
                raise AssertionError("it can write to the memory of another process")
        _search(objective, rng)

    def litters(objective, rng):
        scratch = Path(os.environ["TMPDIR"])
        if list(scratch.glob("left-*")):
            raise AssertionError("a file of another trial")
        (scratch / f"left-{{os.getpid()}}").write_text("mine")
        _search(objective, rng)
"""
EXPECTED = {
    "honest": ("ok", None),
    "edits": ("failed", "readonly database|unable to open"),
    "writes": ("failed", "Read-only file system"),
    "connects": ("failed", "ConnectionRefusedError|Network is unreachable"),
    "kills": ("failed", "ended or stopped twice|exit code 137 twice"),
    "rewrites": ("ok", None),
    "litters": ("ok", None),
}


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """A run in the sandbox of all of these beside an honest optimizer of the package, and the same one alone."""
    import socket

    place = tmp_path_factory.mktemp("sandboxed")
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen()
        facts = {"store": str(place / "out" / "trials.sqlite"), "folder": str(place), "parent": os.getpid()}
        code = dedent(ATTACKS).format(**facts, port=listening.getsockname()[1])
        (place / "attacks.py").write_text(code)
        head = (
            'name = "s"\ntrials = 3\nbudget = 40\n[[problems]]\nname = "sphere-2"\n[[optimizers]]\nname = "scatter"\n'
        )
        attacks = "".join(f'[[optimizers]]\nname = "{place / "attacks.py"}:{name}"\n' for name in EXPECTED)
        for name, text in (("alone", head), ("out", head + attacks)):
            (place / f"{name}.toml").write_text(text)
            run(
                place / f"{name}.toml", place / name, n_jobs=2, timeout=20, sandbox=None if name == "alone" else "bwrap"
            )
    return place


@needed
@pytest.mark.slow
@pytest.mark.parametrize("attack", EXPECTED)
def test_what_each_attack_comes_to(ran, attack):
    frame = load_results(ran / "out")
    rows = frame[frame["optimizer"] == attack]
    status, words = EXPECTED[attack]
    assert list(rows["status"]) == [status] * 3, list(rows["error"])
    if words:
        assert rows["error"].str.contains(words).all(), list(rows["error"])
    assert not (ran / "mark").exists()


@needed
@pytest.mark.slow
def test_the_results_of_others_are_those_of_a_run_without_a_sandbox(ran):
    frames = [load_results(ran / each).drop(columns=TIMES) for each in ("out", "alone")]
    frames = [frame[frame["optimizer"] == "scatter"].reset_index(drop=True).astype(object) for frame in frames]
    pd.testing.assert_frame_equal(*frames, check_exact=True)


@needed
@pytest.mark.slow
def test_stored_trials_are_verified_strictly_in_the_sandbox(ran):
    found = verify(ran / "alone", trials=1, strict=True, sandbox="bwrap")
    assert found.different == {}
    assert "the problem in another process than the optimizer" in found.sentence


@needed
def test_the_scratch_folder_is_all_that_can_be_written():
    writable = "[each for each in ('/', '/dev', '/tmp', '/var/tmp', '/dev/shm') if __import__('os').access(each, 2)]"
    with Process(0, forks=True, command=bubblewrap.command("bwrap")) as process:
        assert process.call(eval, writable) == [bubblewrap.SCRATCH]


def test_one_that_is_unknown_or_missing_is_one_sentence(monkeypatch):
    with pytest.raises(BenchError, match=r"^unknown sandbox 'bwarp'; did you mean 'bwrap'\?"):
        bubblewrap.command("bwarp")
    monkeypatch.setattr(shutil, "which", lambda _: None)
    with pytest.raises(BenchError, match="needs bubblewrap, which is not installed here; install it"):
        bubblewrap.command("bwrap")


@needed
def test_a_plan_loads_no_optimizer_outside_it(bench_here, tmp_path):
    mark = tmp_path / "mark"
    (tmp_path / "mine.py").write_text(f"open({str(mark)!r}, 'w')\ndef mine(objective, rng): pass\n")
    command = ["run", "quick", "--dry-run", "--output", tmp_path / "out", "--optimizer", f"{tmp_path}/mine.py:mine"]
    done = bench_here(*command, "--sandbox", "bwrap")
    assert "Read-only file system" in done.stderr
    assert not mark.exists()
    assert bench_here(*command).returncode == 0
    assert mark.exists()


def test_checks_which_run_outside_are_refused_beside_it(bench_here):
    done = bench_here("run", "quick", "--check", "--sandbox", "bwrap")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("bench: --check runs optimizers outside the sandbox")
