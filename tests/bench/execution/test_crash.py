"""Nothing is lost: runs that are killed, interrupted, out of disk, or two at a time."""

import json
import os
import random
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import time
from contextlib import closing, suppress
from datetime import UTC, datetime, timedelta
from uuid import uuid4

import pandas as pd
import psutil
import pytest

from bench import Results, Study, load_results
from bench.storage.folder import Folder
from tests.bench.sandbox.helpers import hear_interrupts, wait_for

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="signals, process groups and tmpfs as on Linux")

TIMES = ["wall_s", "cpu_s", "objective_s", "memory_mb"]
MARK = "BENCH_CRASH_TEST"
CELLS = 4
PATIENCE = 120.0  # seconds; ends a test that hangs, and decides nothing else
STUDY = """
name = "long"
trials = 1
budget = 40
seed = 3
problems = [{ names = ["slow-2", "sphere-3"] }]
optimizers = [{ name = "hill-climber" }, { name = "scatter" }]
"""


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("crash") / "long.toml"
    path.write_text(STUDY)
    return path


class Run:
    """The command line in a group of its own, as a shell starts it, with a mark on all that belongs to it."""

    def __init__(self, study, folder, *, trials=10, slow=0.01, jobs=2, gate=""):
        self.mark = uuid4().hex
        self._said = (study.parent / f"{self.mark}.txt").open("w+")
        self.began = time.monotonic()
        self.process = subprocess.Popen(
            [sys.executable, "-m", "bench", "run", study, "--output", folder, "--no-report",
             "--jobs", str(jobs), "--trials", str(trials)],
            start_new_session=True, preexec_fn=hear_interrupts, stdout=subprocess.DEVNULL, stderr=self._said,
            env=os.environ | {MARK: self.mark, "SLOW": str(slow), "GATE": str(gate)},
        )  # fmt: skip

    @property
    def going(self):
        return self.process.poll() is None

    def members(self, kind=""):
        """Return the processes of the run: all, or those that load plug-ins and make trials ("trial")."""
        found = []
        for each in psutil.process_iter():
            with suppress(psutil.Error):
                command = " ".join(each.cmdline())
                sort = "trial" if "bench.sandbox.server" in command else "other"
                if each.environ().get(MARK) == self.mark and each.status() != "zombie" and kind in ("", sort):
                    found.append(each)
        return found

    def kill(self, kind, choice):
        """Kill -9 the parent, its group, or one process of a kind; return whether there was one."""
        if kind in ("parent", "group"):
            os.kill(self.process.pid if kind == "parent" else -self.process.pid, signal.SIGKILL)
            return True
        members = self.members(kind)
        if members:
            with suppress(psutil.NoSuchProcess):
                choice.choice(members).kill()
        return bool(members)

    def end(self):
        """Wait for its end; return its exit code and what it said. No process of it may stay."""
        self.process.wait(PATIENCE)
        deadline = time.monotonic() + PATIENCE
        while (left := self.members()) and time.monotonic() < deadline:
            time.sleep(0.02)
        commands = [each.cmdline() for each in left]
        for each in left:
            each.kill()
        assert not commands, "orphans"
        self._said.seek(0)
        return self.process.returncode, self._said.read()


@pytest.fixture
def start(study):
    """Return a function that starts a run, of which nothing stays after the test."""
    runs = []

    def begin(folder, **options):
        runs.append(Run(study, folder, **options))
        return runs[-1]

    yield begin
    for each in runs:
        if each.going:
            os.killpg(each.process.pid, signal.SIGKILL)
            each.process.wait()
        for member in each.members():
            member.kill()
        each._said.close()


def committed(folder):
    """Return the finished trials of a store as another program reads them, and look at the store's health."""
    path = folder / "trials.sqlite"
    if not path.exists():
        return {}
    with closing(sqlite3.connect(f"{path.as_uri()}?mode=ro", uri=True, timeout=10)) as connection:
        if not connection.execute("PRAGMA user_version").fetchone()[0]:
            return {}
        rows = connection.execute(
            "SELECT problem, optimizer, trial, seed, fun, nfev, stop, x, metrics, trace FROM trials WHERE status = 'ok'"
        ).fetchall()
        assert connection.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
    found = {row[:3]: row[3:] for row in rows}
    assert len(found) == len(rows), "a trial stands twice"
    assert None not in {row[-1] for row in rows}, "a trial without its trace"
    return found


def same(one, other):
    """Assert that two folders hold the same results to the last bit, their times apart."""
    pd.testing.assert_frame_equal(
        load_results(one).drop(columns=TIMES), load_results(other).drop(columns=TIMES), check_exact=True
    )
    assert committed(one) == committed(other)


@pytest.mark.slow
def test_kills_lose_nothing_and_change_nothing(start, tmp_path):
    """At random moments, from a run's first: its parent, its whole group, any process that plug-ins are loaded in."""
    kills = 20
    folder, whole, chance = tmp_path / "out", tmp_path / "whole", random.Random(kills)
    first = start(whole, trials=1, slow=0)
    assert first.end()[0] == 0
    usual = time.monotonic() - first.began  # of a whole, short run, on this machine as busy as it is
    ends = ["parent", "group"] * (kills // 8)
    others = ["trial"] * (kills - len(ends))  # roots, fork servers and those in which trials are made
    chance.shuffle(ends)
    chance.shuffle(others)
    seen, planned = {}, 0

    def look():
        """What was there stays as it was."""
        nonlocal seen
        now = committed(folder)
        assert seen.items() <= now.items(), "a committed trial is lost or changed"
        more, seen = len(now) > len(seen), now
        return more

    while ends:
        planned = max(planned, len(seen) // CELLS + 8)
        run = start(folder, trials=planned)
        moment = chance.uniform(0, 1.2 * usual)
        for at in sorted(chance.uniform(0.3, 1) * moment for _ in range(2)):
            time.sleep(max(0, run.began + at - time.monotonic()))
            if others and run.kill(others[-1], chance):
                others.pop()
        time.sleep(max(0, run.began + moment - time.monotonic()))
        look()
        stopped = run.going and run.kill(ends[-1], chance)
        code, said = run.end()
        if stopped:
            ends.pop()
        else:
            assert code in (0, 1), said  # it was done
        look()
    while others:
        planned = max(planned, len(seen) // CELLS + 15)
        run = start(folder, trials=planned)
        while others and run.going:
            assert wait_for(lambda: look() or not run.going)  # goes on by itself after each kill  # noqa: B023
            time.sleep(chance.uniform(0, 0.2))
            for _ in range(min(2, len(others))):
                if run.kill(others[-1], chance):
                    others.pop()
        code, said = run.end()
        assert code in (0, 1), said
        assert "Traceback" not in said
        look()
    assert start(folder, trials=planned, slow=0).end() == (0, "")
    look()
    assert start(whole, trials=planned, slow=0).end() == (0, "")
    assert len(seen) == CELLS * planned
    same(folder, whole)
    assert Folder(folder).running() is None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "jobs", "again"),
    [(signal.SIGINT, 2, False), (signal.SIGINT, 2, True), (signal.SIGINT, 1, True), (signal.SIGTERM, 2, True)],
)
def test_an_interrupt_keeps_what_is_done_and_says_how_to_go_on(start, number, jobs, again, tmp_path):
    """As a terminal does, to the whole group; a polite kill goes to the parent."""
    chance = random.Random(int(number) + 10 * jobs + again)
    for late in (False, True):
        folder = tmp_path / str(late)
        run = start(folder, trials=1000, slow=0.05, jobs=jobs)  # it is not done before it is interrupted
        if late:
            assert wait_for(lambda: committed(folder))  # noqa: B023
            time.sleep(chance.uniform(0, 0.5))
        else:  # in mid-start: of the study's check, of workers, of the first trial
            assert wait_for(lambda: run.members("trial"))  # noqa: B023
            time.sleep(chance.uniform(0, 1.5))
        seen = committed(folder)
        for _ in range(2 if again else 1):
            with suppress(ProcessLookupError):
                os.kill(run.process.pid if number == signal.SIGTERM else -run.process.pid, number)
            time.sleep(chance.uniform(0, 0.2))
        code, said = run.end()
        assert code == 130, said
        assert said == "bench: interrupted; finished trials and slow evaluations are kept: the same command goes on\n"
        now = committed(folder)
        assert seen.items() <= now.items()
        assert Folder(folder).running() is None
        if now:
            assert all(record["ended"] for record in Folder(folder).environments())


@pytest.mark.slow
def test_a_second_run_is_refused_with_the_number_of_the_first(start, study, bench_here, tmp_path):
    folder = tmp_path / "out"
    run = start(folder, trials=1000, slow=0.1)
    assert wait_for(lambda: committed(folder))
    done = bench_here("run", study, "--output", folder)
    assert done.returncode == 2
    assert f"another run (process {run.process.pid} on {socket.gethostname()}, since 2" in done.stderr
    assert done.stderr.count("\n") == 1
    assert f"running: process {run.process.pid} on" in bench_here("status", folder).stdout
    run.kill("parent", random)
    run.end()
    assert (folder / ".under-way").exists()
    assert "running:" not in bench_here("status", folder).stdout


@pytest.mark.slow
def test_one_of_two_first_runs_at_the_same_moment_wins(start, tmp_path):
    folder = tmp_path / "out"
    runs = [start(folder, trials=2, slow=0, gate=tmp_path / "gate") for _ in range(2)]
    assert wait_for(lambda: not all(run.going for run in runs))
    (tmp_path / "gate").touch()  # the other one has begun, and may go on
    ends = sorted(run.end() for run in runs)
    assert [code for code, _ in ends] == [0, 2]
    assert ends[0][1] == ""
    assert "another run (process " in ends[1][1]
    assert ends[1][1].count("\n") == 1
    assert len(committed(folder)) == 2 * CELLS
    assert Study.load(folder / "study.toml").trials == 2
    assert not [each for each in folder.iterdir() if each.suffix == ".tmp"]


def test_a_number_that_another_process_has_by_now_is_no_run(tmp_path):
    began = datetime.fromtimestamp(psutil.Process().create_time(), UTC)
    for seconds, believed in ((-60, False), (0, True), (60, True)):
        noted = {"pid": os.getpid(), "host": socket.gethostname(),
                 "started": (began + timedelta(seconds=seconds)).isoformat(timespec="seconds")}  # fmt: skip
        (tmp_path / ".under-way").write_text(json.dumps(noted))
        assert bool(Folder(tmp_path).running()) is believed
    for odd in ({"pid": "x"}, {"pid": 2**80}, {"pid": -1}, {"started": "yesterday"}, {"started": None}):
        (tmp_path / ".under-way").write_text(json.dumps(noted | odd))
        assert Folder(tmp_path).running() is None
    (tmp_path / ".under-way").write_text("{")
    assert Folder(tmp_path).running() is None


# disks


class Disk:
    """A small file system in memory."""

    def __init__(self, path):
        self.path, self.ballast = path, path / "ballast"

    def mount(self, options):
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", self.path], capture_output=True)
        return done.returncode == 0

    def fill(self, left=0):
        """Leave no more than so many bytes."""
        with suppress(OSError), self.ballast.open("wb", buffering=0) as file:
            while True:
                file.write(bytes(4096))
        if left:
            os.truncate(self.ballast, self.ballast.stat().st_size - left)


@pytest.fixture
def disk(tmp_path):
    """A disk of 1 MB; skipped where one may not be mounted."""
    path = tmp_path / "disk"
    path.mkdir()
    made = Disk(path)
    if not shutil.which("mount") or not made.mount("size=1m"):
        pytest.skip("a tmpfs may not be mounted here")
    yield made
    subprocess.run(["umount", "--lazy", path], check=True)


def one_sentence(done, *parts):
    assert done.returncode == 2, done.stdout + done.stderr
    assert done.stderr.startswith("bench: ")
    assert done.stderr.count("\n") == 1, done.stderr
    for part in parts:
        assert part in done.stderr


@pytest.mark.slow
def test_a_full_disk_stops_a_run_that_then_goes_on(start, disk, tmp_path):
    folder, whole = disk.path / "out", tmp_path / "whole"
    code, said = start(folder, trials=40, slow=0).end()
    assert code == 2
    assert said.startswith("bench: ")
    assert str(folder) in said
    assert said.count("\n") == 1, said
    held = committed(folder)
    assert 4 < len(held) < 40 * CELLS
    assert disk.mount("remount,size=8m")
    assert start(folder, trials=40, slow=0).end() == (0, "")
    assert held.items() <= committed(folder).items()
    start(whole, trials=40, slow=0).end()
    same(folder, whole)


def test_no_room_to_begin_or_to_report_is_one_sentence(bench_here, study, disk):
    folder = disk.path / "out"
    disk.fill()
    command = ["run", study, "--output", folder, "--jobs", 1, "--no-report", "--trials", 2]
    one_sentence(bench_here(*command), str(folder), "No space left on device")
    disk.ballast.unlink()
    assert bench_here(*command).returncode == 0
    disk.fill()
    one_sentence(bench_here("report", folder), str(folder))
    disk.ballast.unlink()
    assert len(load_results(folder)) == 2 * CELLS


KILLED = """
import os, sys
import bench

made = []
class Killer(bench.Listener):
    def trial(self, trial, row):
        made.append(trial)
        if len(made) == 5:
            os.kill(os.getpid(), 9)

bench.run(bench.Study.load(sys.argv[1]).override(trials=3), sys.argv[2], n_jobs=1, progress=Killer())
"""


@pytest.mark.slow
def test_a_killed_run_s_folder_is_read_where_nothing_can_be_written(bench_here, study, disk, tmp_path):
    folder = disk.path / "out"
    assert subprocess.run([sys.executable, "-c", KILLED, study, folder], check=False).returncode == -signal.SIGKILL
    assert (folder / "trials.sqlite-wal").stat().st_size
    assert disk.mount("remount,ro")
    assert len(load_results(folder)) == 5
    assert len(Results(folder).traces) == 5
    assert bench_here("status", folder).returncode == 0
    one_sentence(bench_here("run", study, "--output", folder, "--trials", 3), str(folder), "Read-only file system")
    done = bench_here("report", folder, "--output", tmp_path / "report")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "report" / "report.html").exists()


@pytest.mark.slow
def test_a_folder_without_permission_to_write_is_refused_and_read(start, study, tmp_path):
    folder = tmp_path / "out"
    assert start(folder, trials=2, slow=0).end() == (0, "")
    powerless = ["setpriv", "--bounding-set=-all", "--inh-caps=-all"] if os.geteuid() == 0 else []
    if powerless and not shutil.which("setpriv"):
        pytest.skip("root may write anywhere")

    def command(*arguments):
        return subprocess.run(
            [*powerless, sys.executable, "-m", "bench", *arguments], capture_output=True, text=True, check=False
        )

    folder.chmod(0o555)
    (tmp_path / "closed").mkdir(mode=0o000)
    (tmp_path / "bare").mkdir(mode=0o555)
    try:
        for each in ("out", "closed", "closed/out", "bare", "bare/out"):
            one_sentence(command("run", study, "--output", tmp_path / each, "--jobs", "1"), str(tmp_path / each))
        assert command("status", folder).returncode == 0
        one_sentence(command("status", tmp_path / "closed"))
    finally:
        for each in ("out", "closed", "bare"):
            (tmp_path / each).chmod(0o755)
    assert len(committed(folder)) == 2 * CELLS
