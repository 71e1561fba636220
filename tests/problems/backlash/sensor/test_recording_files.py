"""Which files are selected, and what their names say about joints and times."""

from pathlib import Path

import pytest

from problems.backlash.sensor.recording_files import find, series


def series_of(*names):
    """Return what the names say: joint, unit, and the files with their times, series by series."""
    made = series([Path(name) for name in names])
    return [
        (one.name, one.unit, [(names[i], one.label(at)) for i, at in zip(one.members, one.at, strict=True)])
        for one in made
    ]


def test_a_folder_is_the_recordings_in_it_and_in_its_subfolders_but_no_truth(tmp_path):
    (tmp_path / "j5").mkdir()
    for name in ("a10.csv", "a2.xlsx", "truth.csv", "report.html", ".a.csv", "~$a2.xlsx", "j5/a1.parquet"):
        (tmp_path / name).touch()
    (tmp_path / "folder.csv").mkdir()
    paths = find([tmp_path])
    assert [path.relative_to(tmp_path).as_posix() for path in paths] == ["a2.xlsx", "a10.csv", "j5/a1.parquet"]


@pytest.mark.parametrize(
    ("name", "joint", "label"),
    [
        ("2024-01.csv", "", "2024-01"),
        ("joint4_2024-01.csv", "joint4", "2024-01"),
        ("2024-01-31_joint4.csv", "joint4", "2024-01-31"),
        ("20240229.csv", "", "2024-02-29"),
        ("2024-12-31T2359.csv", "", "2024-12-31"),
        ("j4_2024.03.05_2.csv", "j4", "2024-03-05"),
        ("robot 7 joint4 2023_11.csv", "robot 7 joint4", "2023-11"),
        ("joint4_003.csv", "joint4", "3"),
        ("Speeddata12.xlsx", "Speeddata", "12"),
        ("joint4.csv", "joint4", "1"),
        ("axis 4 after.csv", "axis 4", "1"),
        ("before.csv", "", "1"),
        ("2024-02-31.csv", "2024-02", "31"),  # no such day
        ("200113.csv", "", "2.001e+05"),  # no such month
    ],
)
def test_a_name_tells_the_joint_and_the_time(name, joint, label):
    assert [(found, when) for found, _, [(_, when)] in series_of(name)] == [(joint, label)]


def test_joints_are_told_apart_and_each_is_in_the_order_of_time():
    names = ["joint5_2024-02.csv", "joint4_2024-02-15.csv", "joint4_2024-01-15.csv", "joint5_2023-12.csv"]
    assert series_of(*names) == [
        ("joint5", "month", [(names[3], "2023-12"), (names[0], "2024-02")]),
        ("joint4", "month", [(names[2], "2024-01-15"), (names[1], "2024-02-15")]),
    ]
    assert series([Path("2024-01.csv"), Path("2024-03-16T1200.csv")])[0].at.tolist() == [24288, 24290.5]
