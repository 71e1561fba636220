"""bench calibrate: what it prints and writes, and what it refuses."""

import psutil
import pytest

from problems.backlash.commands.calibrate import calibrate
from problems.backlash.signature.calibration import load_calibration


def test_the_default_gives_the_thesis_s_cubic_its_range_and_its_distance_from_equation_4_7(command):
    said = command(calibrate, "--no-fits")
    assert said.startswith("default joint, simulated, half-gaps 0.0003 … 0.0021 rad\n")
    assert "        0.275503          0.000300\n" in said
    assert "delta = 1e-6 (-0.0015 A^3 + 0.4073 A^2 + 10.7968 A + 17.0994) rad, A in rpm\n" in said
    assert "range: 0.2755 to 1.111 rps" in said
    assert "difference from eq. 4.7 of the thesis: at most 2." in said


def test_another_joint_is_calibrated_into_a_file_with_figures(command, tmp_path):
    (tmp_path / "joint.toml").write_text("payload_kg = 4\n")
    output = tmp_path / "calibration.toml"
    said = command(
        calibrate, "--joint", tmp_path / "joint.toml", "--gaps", "0.0005:0.0015:3",
        "--no-fits", "--output", output, "--plot", tmp_path / "figures",
    )  # fmt: skip
    assert "eq. 4.7" not in said
    assert "delta =" not in said
    assert sorted(path.name for path in (tmp_path / "figures").iterdir()) == [
        "calibration.svg", "disturbances.svg", "signals.svg", "stiffness.svg",
    ]  # fmt: skip
    made = load_calibration(output)
    assert made.half_gap == pytest.approx([0.0005, 0.001, 0.0015])
    assert made.name.startswith("joint with load_inertia = 0.346")
    assert "eq. 4.7" not in (tmp_path / "figures" / "calibration.svg").read_text()


def test_two_processes_make_the_fits_that_one_makes_and_the_file_says_how_to_make_it_again(command, tmp_path):
    given = ["--gaps", "0.0005:0.0011:2"]
    said = {jobs: command(calibrate, *given, "--jobs", jobs, "--output", tmp_path / f"{jobs}.toml") for jobs in (1, 2)}
    commands = [" ".join(child.cmdline()) for child in psutil.Process().children()]
    assert sum("popen_loky" in line for line in commands) == 2  # joblib keeps its idle workers for a while
    assert said[2].replace("2.toml", "1.toml") == said[1]
    text = (tmp_path / "1.toml").read_text()
    assert text.startswith(f"# bench calibrate {' '.join(given)}\n")
    assert (tmp_path / "2.toml").read_text() == text
    assert "amplitude in rps   half-gap in rad   fit in rps   its scatter\n" in said[1]
    assert "        0.405912          0.000500     0.390541      0.002112\n" in said[1]
    made = load_calibration(tmp_path / "1.toml")
    assert made.expected(made.fitted[0]) == pytest.approx(24.3547, abs=1e-4)
    command(calibrate, *given, "--no-fits", "--output", tmp_path / "b.toml")
    assert load_calibration(tmp_path / "b.toml").fitted is None


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--gaps", "0:0.004:x"], "--gaps must be FROM:TO:COUNT"),
        (["--gaps", "0:0.004:1000"], "in 2 to 100 half-gaps"),
        (["--gaps", "0.004:0.001:5"], "--gaps must rise"),
        (["--output", "a.csv"], "a.csv must end in .toml"),
        (["--output", "there.toml"], "is there already"),
        (["--joint", "none.toml"], "joint none.toml cannot be read"),
        (["--plot", "there.toml", "--gaps", "0.0003:0.0005:2", "--no-fits"], "cannot be written"),
    ],
)
def test_wrong_input_is_one_sentence_and_writes_nothing(refused, tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.toml").write_text("mine")
    assert said in refused(calibrate, *arguments)
    assert [path.name for path in tmp_path.iterdir()] == ["there.toml"]
    assert (tmp_path / "there.toml").read_text() == "mine"
