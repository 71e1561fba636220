"""Several joints in one file, and files that are no recordings."""

import numpy as np
import pandas as pd
import pytest

from bench import BenchError
from problems.backlash.recordings import read_joints

T = 0.002 * np.arange(50)
SPEED = {"J4": 100 + T, "J5": 50 + T, "J6": 25 + T}


@pytest.mark.parametrize("kind", ["csv", "parquet", "xlsx"])
@pytest.mark.parametrize("apart", [True, False])
def test_a_column_tells_the_joint_of_each_line(tmp_path, kind, apart):
    parts = [pd.DataFrame({"axis": name, "time_s": T, "speed_rps": speed}) for name, speed in SPEED.items()]
    table = pd.concat(parts).sort_values("axis" if apart else "time_s", kind="stable")
    path = tmp_path / f"cell.{kind}"
    {"csv": table.to_csv, "parquet": table.to_parquet, "xlsx": table.to_excel}[kind](path, index=False)
    made = {name: recording() for name, recording in read_joints(path, joint_column="axis")}
    assert list(made) == list(SPEED)
    for name, speed in SPEED.items():
        np.testing.assert_allclose(made[name].speed, speed)
        assert made[name].dt == pytest.approx(0.002)


def test_each_joint_may_have_a_column(tmp_path):
    path = tmp_path / "cell.csv"
    pd.DataFrame({"time_s": T, **{f"v_{name}_rpm": 60 * speed for name, speed in SPEED.items()}}).to_csv(path)
    made = {name: recording() for name, recording in read_joints(path, joint_column="V_*_rpm")}
    assert list(made) == list(SPEED)
    for name, speed in SPEED.items():
        np.testing.assert_allclose(made[name].speed, speed)


def test_a_joint_that_cannot_be_read_costs_no_other(tmp_path):
    path = tmp_path / "cell.csv"
    rows = [f"{name},{t:.3f},{'off' if name == 5 and t > 0.05 else 100 + t}" for name in (4, 5) for t in T]
    path.write_text("\n".join(["axis,time_s,speed_rps", *rows]))
    (good, first), (bad, second) = read_joints(path, joint_column="axis")
    assert (good, bad) == ("joint4", "joint5")
    np.testing.assert_allclose(first().speed, 100 + T)
    with pytest.raises(BenchError, match="line 78 has no number in column 'speed_rps' but 'off'; fix or cut it"):
        second()
