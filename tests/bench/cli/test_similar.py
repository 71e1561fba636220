"""The command similar."""

import csv

import pytest


def test_it_prints_clusters_and_draws_a_map(bench_here, tmp_path):
    done = bench_here(
        "similar", "hill-climber", "scatter", "--problem", "sphere-[23]", "--trials", "12", "--budget", "25 * d",
        "--jobs", 2, "--plot", tmp_path / "map.svg", "--csv", tmp_path / "pairs.csv",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "Every optimizer differs from every other one." in done.stdout
    text = (tmp_path / "map.svg").read_text(encoding="utf-8")
    assert "hill-climber" in text
    with (tmp_path / "pairs.csv").open() as file:
        (row,) = csv.DictReader(file)
    assert (row["first"], row["second"], row["alike"]) == ("hill-climber", "scatter", "False")
    assert float(row["distance"]) > float(row["floor"])


def test_it_prints_how_many_trials_could_distinguish_any_pair(bench_here, tmp_path):
    done = bench_here(
        "similar", "hill-climber", "scatter", "early", "random-search", "gwo", "--problem", "sphere-2",
        "--trials", "10", "--budget", "60", "--plot", tmp_path / "map.svg",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert (
        "5 against 5 trials can distinguish none of 10 pairs: p is at least 0.0079 before Holm's adjustment; take "
        "--trials 12 or more" in " ".join(done.stdout.split())
    )
    assert "alike, as far as" not in done.stdout
    assert "Every optimizer differs" not in done.stdout


@pytest.mark.slow
def test_the_compiled_cma_es_is_the_same_optimizer(bench_here, tmp_path):
    done = bench_here(
        "similar", "cma-es", "cma-es-fast", "random-search", "--trials", "20", "--budget", "300",
        "--plot", tmp_path / "map.pdf",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "alike, as far as 10 trials can show: cma-es, cma-es-fast" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("scatter",), "at least two optimizers; name another one"),
        (("scatter", "early", "--trials", "9"), "the trials"),
        (("scatter", "early", "--problem", "sphere-2", "--budget", "20 * d"), "of at least 50, not 40"),
        (("scatter", "early", "--budget", "plenty"), "a multiple of the dimension such as '1e4 * d', not 'plenty'"),
        (("scatter", "nobody"), "unknown optimizer 'nobody'"),
        (("scatter", "early", "--plot", "map.txt"), "must end with .svg, .pdf or .png"),
        (("scatter", "early", "--set", "wings=2"), "wings"),
    ],
)
def test_bad_input_costs_one_sentence(bench_here, arguments, reason):
    done = bench_here("similar", *arguments)
    assert done.returncode == 2
    assert reason in done.stderr
    assert done.stderr.count("\n") == 1
