"""bench estimate: what it prints and draws, and what it refuses."""

import json
import re

import pytest
import typer

from problems.backlash.commands.estimate import estimate
from problems.backlash.joint.writing import write_recording
from problems.backlash.signature.datasets import noisy
from tests.problems.backlash.cut import cut


@pytest.fixture(scope="module")
def calibration(tmp_path_factory):
    path = tmp_path_factory.mktemp("calibration") / "joint.toml"
    path.write_text('name = "mine"\namplitude_rpm = [0.0, 60.0, 120.0]\nhalf_gap_rad = [0.0, 0.002, 0.004]\n')
    return path


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """A recording of two load turns and a bit."""
    path = tmp_path_factory.mktemp("recordings") / "joint4.csv"
    made = cut(noisy(8), 0.0, 0.9)
    write_recording(path, made.time, made.speed)
    return path


LEVELS = 3, 6, 9, 12  # half-gaps of 0.5, 1.1, 1.7 and 2.3 mrad
PLAIN = "--resamples", 0


def part(level, end=0.9):
    return cut(noisy(level), 0.0, end)


@pytest.fixture
def series(tmp_path):
    """A recording a month of a joint that wears."""
    for month, level in enumerate(LEVELS, 1):
        made = part(level)
        write_recording(tmp_path / f"2024-0{month}.csv", made.time, made.speed)
    (tmp_path / "truth.csv").touch()
    return tmp_path


def ended(*arguments):
    """Return the exit code of the command."""
    app = typer.Typer()
    app.command()(estimate)
    return app([*map(str, arguments)], standalone_mode=False) or 0


def test_one_recording_is_measured(command, recording, calibration, tmp_path):
    picture = tmp_path / "a.svg"
    said = command(estimate, recording, "--calibration", calibration, "--resamples", 3, "--plot", picture)
    assert said.startswith(f"{recording}: early backlash, up to the limit of 2.1 mrad\n")
    assert "calibration  mine" in said
    assert said.endswith(f"{picture}\n")
    assert picture.stat().st_size > 10_000
    found = float(said.partition("half-gap")[2].split()[0])
    assert found == pytest.approx(2 * noisy(8).peak, rel=0.1)  # by that calibration, in mrad


def test_a_bad_file_costs_itself_only(series, calibration, capsys):
    (series / "2024-03.csv").write_text("t,v\n0,1\n1,a\n2,3\n")
    assert ended(series, "--calibration", calibration, *PLAIN, "--json") == 1
    printed = capsys.readouterr()
    made = json.loads(printed.out)
    reason, total = printed.err.splitlines()  # no bar, as there is no terminal
    assert reason.startswith(f"bench: recording {series / '2024-03.csv'}: line 3 has no number")
    assert total == "bench: 1 of the 4 recordings could not be estimated"
    assert [list(each) == ["file", "error"] for each in made] == [False, False, True, False]
    assert "2024-03.csv: line 3 has no number" in made[2]["error"]


def test_joints_of_one_file_have_rows_and_trends_of_their_own(command, tmp_path):
    for month, levels in enumerate(((3, 9), (6, 12)), 1):
        made = [(joint, part(level)) for joint, level in zip((4, 5), levels, strict=True)]
        rows = [f"{joint},{t},{v}" for joint, each in made for t, v in zip(each.time, each.speed, strict=True)]
        (tmp_path / f"2024-0{month}.csv").write_text("\n".join(["axis,time_s,speed_rps", *rows]))
    said = command(estimate, tmp_path, "--joint-column", "axis", *PLAIN)
    assert "2024-01.csv (joint4)" in said
    assert re.search(r"joint4: half-gap 0\.[45]\d+ mrad in 2024-01, 1\.[01]\d+ in 2024-02", said)
    assert re.search(r"joint5: half-gap 1\.[67]\d+ mrad in 2024-01, 2\.[23]\d+ in 2024-02", said)


@pytest.mark.parametrize(("levels", "code"), [((3, 14), 3), ((14, 3), 0), ((3, None), 1), ((14, None), 3)])
def test_the_exit_code_follows_the_latest_verdict_of_each_joint(tmp_path, levels, code, capsys):
    """3 for an alarm, 1 for a recording that failed, 0 else; 2 is bad input's."""
    for month, level in enumerate(levels, 1):
        path = tmp_path / f"2024-0{month}.csv"
        if level is None:
            path.write_text("t,v\n0,1\n1,x\n2,1\n")
        else:
            write_recording(path, part(level).time, part(level).speed)
    assert ended(tmp_path, "--fail-on", "progressed", *PLAIN) == code
    assert ("the latest verdict is progressed" in capsys.readouterr().err) == (code == 3)


def test_a_series_ends_with_its_trend_and_a_picture_of_it(command, series):
    said = command(estimate, series, "--plot", series / "trend.svg", "--limit", 0.002, *PLAIN)
    assert [line.split()[1] for line in said.splitlines()[1:6]] == ["file", *(f"2024-0{i}.csv" for i in range(1, 5))]
    assert re.search(r"trend: half-gap 0\.[45]\d+ mrad in 2024-01, 2\.[23]\d+ in 2024-04: a change of \+1\.[78]", said)
    assert "  the limit of 2 mrad has been passed in 2024-04\n" in said
    assert said.endswith(f"{series / 'trend.svg'}\n")
    assert "half-gap" in (series / "trend.svg").read_text()


def test_every_option_reaches_the_estimate(command, tmp_path, calibration):
    made, path = part(12, end=2.0), tmp_path / "a.csv"
    rows = [f"{60 * v:.6f};{1e3 * t:.3f};1" for t, v in zip(made.time, made.speed, strict=True)]
    path.write_text("\n".join(["speed;time_ms;ref", *rows]))
    options = ["--speed", 1, "--unit", "rpm", "--window", "0.4:1.6", "--resamples", 5, "--limit", 0.001, "--json"]
    (found,) = json.loads(command(estimate, path, *options, "--calibration", calibration, "--gear-ratio", 40))
    assert (found["verdict"], found["calibration"], found["period_source"]) == ("progressed", "mine", "gear ratio")
    assert found["amplitude_rps"] == pytest.approx(noisy(12).peak, rel=0.15)
    assert found["interval_rad"][0] < found["backlash_rad"] < found["interval_rad"][1]
    (plain,) = json.loads(command(estimate, path, *options, "--calibration", "none", *PLAIN))
    assert (plain["verdict"], plain["backlash_rad"]) == ("backlash", None)
    assert plain["amplitude_interval_rps"] == [None, None]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["none.csv"], "recording none.csv: there is no such file"),
        (["."], "there is no recording in the folder ."),
        (["a.csv", "--calibration", "none.toml"], "calibration none.toml cannot be read"),
        (["a.csv", "--window", "3"], "'3' is not a window"),
        (["a.csv", "--page", "none/a.html"], "none/a.html cannot be written: there is no folder none"),
        (["a.csv", "--plot", "a.jpg"], "a.jpg must end in .svg, .png, .pdf"),
        (["a.csv", "--resamples", 10**30], "resamples must be a whole number from 0 to 1000000"),
        (["a.csv", "--gear-ratio", 0], "gear ratio must be a positive number"),
    ],
)
def test_wrong_input_is_one_sentence(refused, tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(tmp_path)
    assert said in refused(estimate, *arguments)
