"""Optimizers that hang, crash, lie and litter: each costs only its own trials, whatever it does."""

import re
import sys

import pandas as pd
import psutil
import pytest

from bench import load_results, run

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform == "win32", reason="signals, forks and limits of POSIX"),
]

HEAD = 'name = "{name}"\ntrials = 2\nbudget = 60\n[[problems]]\nnames = ["sphere-2", "sphere-3"]\n'
HONEST = '[[optimizers]]\nname = "scatter"\n[[optimizers]]\nname = "hill-climber"\n'
TIMES = ["wall_s", "cpu_s", "objective_s", "memory_mb", "study"]
PRINTED, GLOBAL, RUNNING = "printed more than 1 MB", "used the global random state", "running, in the time of"
EXPECTED = {
    "raise": ("failed", "ValueError: "),
    "raise-base": ("failed", "SeriousError: no"),
    "raise-exit": ("failed", "SystemExit: 0"),
    "raise-interrupt": ("failed", "KeyboardInterrupt: no message"),
    "raise-unspeakable": ("failed", "UnspeakableError: its message cannot be read: SystemExit"),
    "recurse": ("failed", "RecursionError"),
    "return-nothing-done": ("failed", "returned without a single evaluation"),
    "generator": ("failed", "returned without a single evaluation"),
    "coroutine": ("failed", "returned without a single evaluation"),
    "points-shape": ("failed", "expected points of shape (n, 2) or (2,), got (2, 7)"),
    "points-ragged": ("failed", "inhomogeneous shape"),
    "points-complex": ("failed", "points must be real numbers, not complex128"),
    "points-text": ("failed", "points must be real numbers, not <U1"),
    "points-objects": ("failed", "TypeError"),
    "points-nan": ("failed", "its best point has values that are no numbers"),
    "points-none": ("failed", "expected points of shape"),
    "spin": ("timeout", "(--timeout)"),
    "native": ("timeout", "(--timeout)"),
    "swallow": ("timeout", "(--timeout)"),
    "freeze": ("timeout", "(--timeout)"),
    "ask-for-ever": ("failed", "went on asking for values after its budget was spent"),
    "allocate": ("failed", "MB of memory, where 400 MB are allowed (--memory)"),
    "exit-0": ("failed", "its process ended with exit code 0"),
    "exit-3": ("failed", "its process ended with exit code 3"),
    "crash": ("failed", "its process ended with signal SIGSEGV"),
    "abort": ("failed", "its process ended with signal SIGABRT"),
    "kill": ("failed", "signal SIGKILL twice; the machine may be short of memory"),
    "print": ("failed", PRINTED),
    "print-errors": ("failed", PRINTED),
    "write-1": ("failed", PRINTED),
    "write-2": ("failed", PRINTED),
    "threads": ("failed", f"left threads {RUNNING}"),
    "daemons": ("failed", f"left threads {RUNNING}"),
    "fork-and-stay": ("failed", f"left processes {RUNNING}"),
    "processes": ("failed", f"left processes {RUNNING}"),
    "seed": ("failed", GLOBAL),
    "patch": ("failed", "AttributeError"),
    "forget": ("failed", ""),
    "close-files": ("failed", "closed files that are not its own"),
}
HARMLESS = ("ask-twice", "kill-once", "print-little", "fork", "change", "close-output", "stop")


def entry(deed):
    own = deed in ("generator", "coroutine")
    return f'[[optimizers]]\nname = "{deed if own else "hostile"}"\n' + (
        "" if own else f'label = "{deed}"\ndeed = "{deed}"\n'
    )


@pytest.fixture(scope="module")
def ran(bench, tmp_path_factory):
    """A run of all of them beside two honest optimizers: what the command said, and its folder."""
    place = tmp_path_factory.mktemp("hostile")
    text = HEAD.format(name="hostile") + "".join(map(entry, [*EXPECTED, *HARMLESS])) + HONEST
    (place / "study.toml").write_text(text)
    limits = ("--jobs", 3, "--timeout", 4, "--memory", 0.4)
    marker = str(place / "marker")
    done = bench("run", place / "study.toml", "--output", place / "out", *limits, MARKER=marker)
    return done, place / "out", marker


@pytest.fixture(scope="module")
def frame(ran):
    return load_results(ran[1])


def of(frame, deed, problem="sphere-2"):
    return frame[(frame["optimizer"] == deed) & (frame["problem"] == problem)]


@pytest.mark.parametrize("deed", EXPECTED)
def test_each_ends_as_a_row_with_its_reason(frame, deed):
    status, words = EXPECTED[deed]
    rows = of(frame, deed)
    assert len(rows) == 2
    assert rows["status"].eq(status).all()
    assert all(words in error for error in rows["error"]), list(rows["error"])


@pytest.mark.parametrize("deed", HARMLESS)
def test_what_harms_nobody_does_not_fail(frame, deed):
    assert of(frame, deed)["status"].eq("ok").all()


def test_trials_elsewhere_are_all_finished(frame):
    assert frame.loc[frame["problem"] == "sphere-3", "status"].eq("ok").all()


def test_honest_results_are_the_same_to_the_last_bit_as_without_them(frame, tmp_path, testing_plugins):
    (tmp_path / "study.toml").write_text(HEAD.format(name="honest") + HONEST)
    run(tmp_path / "study.toml", tmp_path / "out", n_jobs=1)
    alone = load_results(tmp_path / "out").drop(columns=TIMES)
    mine = frame[frame["optimizer"].isin(["scatter", "hill-climber"])].drop(columns=TIMES).reset_index(drop=True)
    assert len(mine) == 8
    pd.testing.assert_frame_equal(mine.astype(object), alone.astype(object), check_exact=True)


def test_the_command_fails_and_says_little(ran):
    done = ran[0]
    assert done.returncode == 1
    assert len(done.stdout + done.stderr) < 30_000
    assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f\u202e]", done.stdout + done.stderr)
    assert "78 trials failed" in done.stdout + done.stderr


def test_no_process_is_left(ran):
    left = []
    for process in psutil.process_iter(["pid", "environ"]):
        if (process.info["environ"] or {}).get("MARKER") == ran[2]:
            left.append(process)
    assert left == []


def test_the_status_and_the_report_say_the_reasons(ran, bench_here):
    status = bench_here("status", ran[1]).stdout
    assert "failed: raise on " in status
    assert "more reasons" in status
    page = (ran[1] / "report.html").read_text(encoding="utf-8")
    counted = re.findall(r'<p class="lost">(\d+) of \d+ trials did not finish \((.*?)\)', page)
    assert counted == [("78", "70 failed and 8 timed out")]
    assert (
        page.count('<td><span class="lost">2</span></td>') > 39 + 30
    )  # cells, and reasons, but for those with numbers
    assert "its process ended with signal SIGSEGV" in page


def test_no_escape_or_markup_of_theirs_reaches_a_file(ran):
    files = [file for file in ran[1].rglob("*") if file.suffix in (".html", ".tex", ".md", ".csv", ".json")]
    assert len(files) > 10
    for file in files:
        text = file.read_text(encoding="utf-8")
        assert "\x1b" not in text
        if file.suffix == ".html":
            assert "<script>alert(1)" not in text
        if file.suffix == ".tex":
            assert "\\input{x}" not in text
