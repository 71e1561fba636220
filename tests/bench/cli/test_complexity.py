"""The command complexity."""

import csv

import pytest


def test_it_prints_and_writes_the_table(bench_here, tmp_path):
    files = ("--csv", tmp_path / "c.csv", "--tex", tmp_path / "c.tex")
    asked = ("random-search", "--problem", "sphere-[23]", "--evaluations", "100", "--runs", "1")
    done = bench_here("complexity", *asked, *files)
    assert done.returncode == 0, done.stderr
    assert "(T2 − T1) / T0" in done.stdout
    assert "100 evaluations, T2 the mean of 1 runs" in done.stdout
    with (tmp_path / "c.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["problem"], row["dimension"]) for row in rows] == [("sphere-2", "2"), ("sphere-3", "3")]
    assert "sphere-3 & 3 & random-search & " in (tmp_path / "c.tex").read_text()


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("random-serch",), "unknown optimizer 'random-serch'"),
        (("random-search", "--problem", "spheres-*"), "no problem matches 'spheres-*'"),
        (("random-search", "--runs", "0"), "the runs"),
        (("random-search", "--evaluations", "0"), "the evaluations"),
    ],
)
def test_bad_input_costs_one_sentence(bench_here, arguments, reason):
    done = bench_here("complexity", *arguments)
    assert done.returncode == 2
    assert reason in done.stderr
    assert done.stderr.count("\n") == 1
