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
RUNNING = "running, in the time of"
EXPECTED = {
    "raise": ("failed", "ValueError: "),
    "raise-exit": ("failed", "SystemExit: 0"),
    "raise-unspeakable": ("failed", "UnspeakableError: its message cannot be read: SystemExit"),
    "native": ("timeout", "(--timeout)"),
    "swallow": ("timeout", "(--timeout)"),
    "freeze": ("timeout", "(--timeout)"),
    "ask-for-ever": ("failed", "went on asking for values after its budget was spent"),
    "allocate": ("failed", "MB of memory, where 400 MB are allowed (--memory)"),
    "crash": ("failed", "its process ended with signal SIGSEGV"),
    "kill": ("failed", "signal SIGKILL twice; the machine may be short of memory"),
    "write": ("failed", "printed more than 1 MB"),
    "threads": ("failed", f"left threads {RUNNING}"),
    "fork-and-stay": ("failed", f"left processes {RUNNING}"),
    "processes": ("failed", f"left processes {RUNNING}"),
    "patch": ("failed", "AttributeError"),
    "forget": ("failed", ""),
    "close-files": ("failed", "closed files that are not its own"),
}
HARMLESS = ("kill-once", "change", "stop")


def entry(deed):
    return f'[[optimizers]]\nname = "hostile"\nlabel = "{deed}"\ndeed = "{deed}"\n'


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
    assert "34 trials failed" in done.stdout + done.stderr


def test_no_process_is_left(ran):
    left = []
    for process in psutil.process_iter(["pid", "environ"]):
        if (process.info["environ"] or {}).get("MARKER") == ran[2]:
            left.append(process)
    assert left == []


def test_the_status_and_the_report_say_the_reasons(ran, bench_here):
    status = bench_here("status", ran[1]).stdout
    assert "failed: raise on " in status
    page = (ran[1] / "report.html").read_text(encoding="utf-8")
    counted = re.findall(r'<p class="lost">(\d+) of \d+ trials did not finish \((.*?)\)', page)
    assert counted == [("34", "28 failed and 6 timed out")]
    assert page.count('<td><span class="lost">2</span></td>') > 18 + 10  # cells, and reasons that no number tells apart
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
