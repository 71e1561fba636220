"""The command describe."""

import csv

import pytest


def test_it_prints_and_writes_the_features(bench_here, tmp_path):
    done = bench_here("describe", "sphere-[23]", "--points", "60", "--csv", tmp_path / "features.csv")
    assert done.returncode == 0, done.stderr
    assert "ela_meta.quad_simple.adj_r2" in done.stdout
    with (tmp_path / "features.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["problem"] for row in rows] == ["sphere-2", "sphere-3"]
    assert [float(row["ela_meta.quad_simple.adj_r2"]) for row in rows] == pytest.approx([1, 1])


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("sphere-99",), "unknown problem 'sphere-99'"),
        (("spheres-*",), "no problem matches 'spheres-*'"),
        (("sphere-2", "--points", "5"), "at least 30 points, not 5"),
        (("sphere-2", "--seed", "-1"), "the seed"),
    ],
)
def test_bad_input_costs_one_sentence(bench_here, arguments, reason):
    done = bench_here("describe", *arguments)
    assert done.returncode == 2
    assert reason in done.stderr
    assert done.stderr.count("\n") == 1
