"""bench simulate: recordings, joints and wear curves it writes, and what it refuses."""

import numpy as np
import pandas as pd
import pytest

from problems.backlash.commands.simulate import simulate
from problems.backlash.joint import half_gap, load_joint
from problems.backlash.joint import simulate as run


def written(place, **parameters):
    """Write a joint's file and return its path."""
    path = place / "given.toml"
    path.write_text("".join(f"{name} = {value}\n" for name, value in parameters.items()))
    return path


def test_the_file_holds_the_simulated_motion(command, tmp_path):
    path = tmp_path / "a.csv"
    said = command(simulate, path, "--level", 12, "--duration", 0.6)
    made = run(half_gap=half_gap(12), duration=0.6)
    table = pd.read_csv(path)
    assert list(table) == ["time_s", "speed_rps", "position_rad", "current_a"]
    written = np.column_stack([made.time, made.speed, made.position, made.current])
    np.testing.assert_allclose(table.to_numpy(), written, atol=1e-6)
    assert said == f"{path}: 301 samples, half-gap 0.0023 rad, peak disturbance {made.peak:.4f} rps\n"


def test_every_option_reaches_the_simulation(command, tmp_path):
    path = tmp_path / "a.csv"
    parameters = {"payload_kg": 4.0, "speed_rps": 80.0, "gravity_angle_deg": 60.0, "coulomb_friction": 0.1}
    joint = written(tmp_path, **parameters)
    command(simulate, path, "--half-gap", 0.001, "--joint", joint, "--duration", 0.8, "--start-angle", 1,
            "--encoder-bits", 16)  # fmt: skip
    made = run(load_joint(**parameters), half_gap=0.001, duration=0.8, start_angle=1.0, encoder_bits=16)
    np.testing.assert_allclose(pd.read_csv(path)["speed_rps"], made.speed, atol=1e-6)


def test_noise_is_added_by_the_seed(command, tmp_path):
    def speed(name, *arguments):
        command(simulate, tmp_path / name, "--level", 3, "--duration", 0.4, *arguments)
        return pd.read_csv(tmp_path / name)["speed_rps"].to_numpy()

    clean, first = speed("a.csv"), speed("b.csv", "--noise", 0.3, "--seed", 1)
    np.testing.assert_array_equal(speed("c.csv", "--noise", 0.3, "--seed", 1), first)
    assert np.abs(speed("d.csv", "--noise", 0.3, "--seed", 2) - first).max() > 0.1
    assert 0.27 < np.ptp(first - clean) <= 0.3


def test_wear_writes_a_recording_a_month_and_the_truth(command, tmp_path):
    folder = tmp_path / "wear"
    said = command(simulate, folder, "--wear", 13, "--level", 3, "--worn", 0.002, "--duration", 0.4, "--seed", 5)
    names = [f"2024-{month:02d}" for month in range(1, 13)] + ["2025-01"]
    assert sorted(path.name for path in folder.iterdir()) == [*(f"{name}.csv" for name in names), "truth.csv"]
    truth = pd.read_csv(folder / "truth.csv")
    assert list(truth["month"]) == names
    assert truth["half_gap_rad"].iloc[[0, -1]].tolist() == pytest.approx([0.0005, 0.002])
    for name, gap, amplitude in (truth.iloc[0], truth.iloc[-1]):
        assert run(half_gap=gap, duration=0.8).peak == pytest.approx(amplitude, rel=2e-3), name
    assert "13 months of 201 samples, half-gap 0.0005 to 0.002 rad" in said
    assert "noise of 0.2 rps peak to peak" in said
    command(simulate, tmp_path / "b", "--wear", 13, "--level", 3, "--worn", 0.002, "--duration", 0.4, "--seed", 5)
    for name in names:
        assert (tmp_path / "b" / f"{name}.csv").read_bytes() == (folder / f"{name}.csv").read_bytes()


def test_a_wear_curve_replaces_another_whole_and_only_when_forced(command, refused, tmp_path):
    months = ("--duration", 0.1, "--wear")
    command(simulate, tmp_path / "w", *months, 4)
    assert "holds a wear curve already" in refused(simulate, tmp_path / "w", *months, 2)
    assert "is no wear" in refused(simulate, tmp_path / "w", *months, 2, "--force", "--worn", 0)
    assert len(list((tmp_path / "w").iterdir())) == 5
    command(simulate, tmp_path / "w", *months, 2, "--force")
    assert len(list((tmp_path / "w").iterdir())) == 3
    (tmp_path / "w" / "thesis.docx").write_text("mine")
    assert "holds other files, such as thesis.docx" in refused(simulate, tmp_path / "w", *months, 2, "--force")
    assert [path.name for path in tmp_path.iterdir()] == ["w"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["a.csv"], "give either --level 1 … 20 or --half-gap in rad"),
        (["a.csv", "--level", 3, "--half-gap", 0.1], "not both"),
        (["a.ods", "--level", 3], "a.ods must end in .csv"),
        (["a.csv", "--level", 3, "--worn", 0.003], "--worn is the gap of the last month of --wear"),
        (["a.toml", "--level", 3], "which hold no gap"),
        (["a.csv", "--level", 3, "--joint", "none.toml"], "joint none.toml cannot be read"),
        (["a.csv", "--level", 3, "--duration", 1e9], "at most 200 s"),
        (["w", "--wear", 1], "from 2 to 240 months, not 1"),
        (["none/w", "--wear", 3], "there is no folder none"),
    ],
)
def test_wrong_input_is_one_sentence_and_writes_nothing(refused, tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(tmp_path)
    assert said in refused(simulate, *arguments)
    assert list(tmp_path.iterdir()) == []
