"""bench estimate: what it prints and draws, and what it refuses."""

import json

import numpy as np
import pytest
import typer

import problems.backlash.sensor.batch as batch
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


@pytest.fixture
def stub(monkeypatch, make_estimate):
    """Estimate every recording as the first digit of its speed in mrad; return the settings of each estimate."""
    seen = []

    def estimate(recording, settings):
        seen.append((recording, settings))
        return make_estimate(0.001 * int(str(abs(recording.speed[0]))[0]), recording=recording)

    monkeypatch.setattr(batch, "estimate", estimate)
    return seen


@pytest.fixture
def series(tmp_path):
    for month in range(1, 5):
        (tmp_path / f"2024-0{month}.csv").write_text(f"t,v\n0,{month}\n1,{month}\n2,{month}\n3,{month}.5\n")
    (tmp_path / "truth.csv").touch()
    return tmp_path


def test_one_recording_is_measured(command, recording, calibration, tmp_path):
    picture = tmp_path / "a.svg"
    said = command(estimate, recording, "--calibration", calibration, "--resamples", 3, "--plot", picture)
    assert said.startswith(f"{recording}: early backlash, up to the limit of 2.1 mrad\n")
    assert "calibration  mine" in said
    assert said.endswith(f"{picture}\n")
    assert picture.stat().st_size > 10_000
    found = float(said.partition("half-gap")[2].split()[0])
    assert found == pytest.approx(2 * noisy(8).peak, rel=0.1)  # by that calibration, in mrad


def test_a_bad_file_costs_itself_only(stub, series, calibration, capsys):
    (series / "2024-03.csv").write_text("t,v\n0,1\n1,a\n2,3\n")
    app = typer.Typer()
    app.command()(estimate)
    options = ["--calibration", str(calibration), "--window", ":2.5", "--json"]
    assert app([str(series), *options], standalone_mode=False) == 1
    printed = capsys.readouterr()
    made = json.loads(printed.out)
    _, reason, total = printed.err.splitlines()  # no bar, as there is no terminal
    assert reason.startswith(f"bench: recording {series / '2024-03.csv'}: line 3 has no number")
    assert total == "bench: 1 of the 4 recordings could not be estimated"
    assert [list(each) == ["file", "error"] for each in made] == [False, False, True, False]
    assert "2024-03.csv: line 3 has no number" in made[2]["error"]


def test_a_text_among_the_recordings_of_a_folder_is_a_note(command, stub, series, calibration, refused, capsys):
    (series / "notes.txt").write_text("Joint 4 was greased on 2024-01-05.\n")
    app = typer.Typer()
    app.command()(estimate)
    assert not app([str(series), "--calibration", str(calibration)], standalone_mode=False)
    printed = capsys.readouterr()
    assert "notes.txt" not in printed.out
    assert printed.err.splitlines()[1].endswith("notes.txt has too few samples for a load turn: 1; it was left out")
    assert "notes.txt has too few samples" in refused(estimate, series / "notes.txt")


def test_joints_of_one_file_have_rows_and_trends_of_their_own(command, stub, series):
    for month in range(1, 5):
        rows = [f"{joint},{i},{(month + joint) % 10}.{i}" for joint in (4, 5) for i in range(3)]
        (series / f"2024-0{month}.csv").write_text("\n".join(["axis,t,v", *rows]))
    said = command(estimate, series, "--joint-column", "axis")
    assert "2024-01.csv (joint4)" in said
    assert "joint4: half-gap 5.000 mrad in 2024-01, 8.000 in 2024-04" in said
    assert "joint5: half-gap 6.000 mrad in 2024-01, 9.000 in 2024-04" in said


@pytest.mark.parametrize(("verdicts", "code"), [("1", 0), ("19", 3), ("91", 0), ("1x", 1), ("9x", 3)])
def test_the_exit_code_follows_the_latest_verdict_of_each_joint(
    monkeypatch, make_estimate, tmp_path, calibration, verdicts, code, capsys
):
    """3 for an alarm, 1 for a recording that failed, 0 else; 2 is bad input's."""
    words = {"1": "early", "9": "progressed"}
    monkeypatch.setattr(
        batch, "estimate", lambda recording, _: make_estimate(verdict=words[str(abs(recording.speed[0]))[0]])
    )
    for month, verdict in enumerate(verdicts, 1):
        (tmp_path / f"2024-0{month}.csv").write_text(f"t,v\n0,{verdict}\n1,{verdict}\n2,{verdict}\n3,{verdict}.5\n")
    app = typer.Typer()
    app.command()(estimate)
    options = [str(tmp_path), "--calibration", str(calibration), "--fail-on", "progressed"]
    assert (app(options, standalone_mode=False) or 0) == code
    assert ("the latest verdict is progressed" in capsys.readouterr().err) == (code == 3)


def test_a_series_ends_with_its_trend_and_a_picture_of_it(command, stub, series):
    said = command(estimate, series, "--plot", series / "trend.svg", "--limit", 0.0035)
    assert [line.split()[1] for line in said.splitlines()[1:6]] == ["file", *(f"2024-0{i}.csv" for i in range(1, 5))]
    assert "trend: half-gap 1.000 mrad in 2024-01, 4.000 in 2024-04: a change of +3.000" in said
    assert "  the limit of 3.5 mrad has been passed in 2024-04\n" in said
    assert said.endswith(f"{series / 'trend.svg'}\n")
    assert "half-gap" in (series / "trend.svg").read_text()


def test_files_of_different_joints_have_no_trend(command, stub, series):
    other = (series / "2024-02.csv").rename(series / "joint5_2024-02.csv")
    said = command(estimate, series / "2024-01.csv", other, "--plot", series / "trend.svg")
    assert said.splitlines()[-1].startswith("no joint has two recordings, so there is no trend to draw")
    assert not (series / "trend.svg").exists()


def test_every_option_reaches_the_estimate(command, stub, tmp_path, calibration):
    path = tmp_path / "a.csv"
    path.write_text("speed;time_ms;ref\n" + "\n".join(f"{60 * (100 + i)};{1000 * i};1" for i in range(9)))
    command(
        estimate, path, "--speed", 1, "--unit", "rpm", "--window", "2:7", "--single", "--calibration", calibration,
        "--limit", 0.003, "--resamples", 7,
    )  # fmt: skip
    ((recording, settings),) = stub
    np.testing.assert_allclose(recording.speed, np.arange(102, 108))
    assert (recording.start, recording.dt) == (2.0, 1.0)
    assert (settings.single, settings.gear_ratio) == (True, None)
    assert (settings.limit_rad, settings.resamples) == (0.003, 7)
    assert settings.calibration.name == "mine"
    command(estimate, path, "--speed", "ref", "--unit", "deg", "--gear-ratio", 40, "--calibration", "none")
    recording, settings = stub[1]
    assert (recording.dt, len(recording.speed), recording.speed[0]) == (1.0, 8, 0.0)  # the position stands still
    assert (settings.calibration, settings.gear_ratio, settings.resamples) == (None, 40.0, 200)


def test_nothing_that_can_be_estimated_is_an_error(refused, tmp_path, capsys):
    (tmp_path / "a.csv").write_text("t,v\n0,1\n1,a\n2,3\n")
    (tmp_path / "b.csv").write_text("t,v\n0,1\n1,1\n2,1\n")
    assert refused(estimate, tmp_path, "--calibration", "none") == "none of the 2 recordings could be estimated"
    assert "b.csv: the speed is constant" in refused(estimate, tmp_path / "b.csv", "--calibration", "none")
    capsys.readouterr()
    assert "line 3 has no number" in refused(estimate, tmp_path / "a.csv", "--calibration", "none", "--json")
    (record,) = json.loads(capsys.readouterr().out)
    assert "line 3 has no number" in record["error"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["none.csv"], "recording none.csv: there is no such file"),
        (["."], "there is no recording in the folder ."),
        (["x*.csv"], "no file matches x*.csv"),
        (["a.csv", "--calibration", "none.toml"], "calibration none.toml cannot be read"),
        (["a.csv", "--window", "3"], "'3' is not a window"),
        (["a.csv", "--page", "none/a.html"], "none/a.html cannot be written: there is no folder none"),
        (["a.csv", "--csv", "none/a.csv"], "none/a.csv cannot be written: there is no folder none"),
        (["a.csv", "--plot", "a.jpg"], "a.jpg must end in .svg, .png, .pdf"),
        (["a.csv", "--plot", "none/a.svg"], "there is no folder none"),
        (["a.csv", "--resamples", 10**30], "resamples must be a whole number from 0 to 1000000"),
        (["a.csv", "--gear-ratio", 0], "gear ratio must be a positive number"),
    ],
)
def test_wrong_input_is_one_sentence(refused, tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(tmp_path)
    assert said in refused(estimate, *arguments)
