"""What ``bench list`` prints about optimizers: lineage, parameters, families, and what failed to load."""

import sys

from typer.testing import CliRunner

from bench.cli.app import app


def test_an_optimizer_is_listed_with_its_lineage(bench_here):
    done = bench_here("list", "gwo")
    text = " ".join(done.stdout.split())
    assert done.returncode == 0
    assert "paper Mirjalili et al., 2014, Grey Wolf Optimizer, doi:10.1016/j.advengsoft.2013.12.007" in text
    assert "agents=30 (>= 3), handling='repair' ('repair' | 'box'), variant='code' ('code' | 'cascade')" in text
    assert "package testing-plugins 1.0" in " ".join(bench_here("list", "hill-climber").stdout.split())


def test_a_plugin_that_fails_to_import_is_named_and_hides_no_other(bench_here):
    text = " ".join(bench_here("list", "optimizers").stdout.split())
    assert "'broken' of bench.optimizers (testing_plugins_missing:Nothing) failed to load: ModuleNotFoundError" in text
    assert "hill-climber A (1+1)-ES" in text


def listed(monkeypatch, missing, *words):
    """Return what a list prints where a library is missing."""
    monkeypatch.setitem(sys.modules, missing, None)
    done = CliRunner().invoke(app, ["list", *words])
    assert done.exit_code == 0, done.output
    return " ".join(done.output.split())


def test_a_search_finds_a_member_whose_library_is_missing_and_names_the_extra(monkeypatch):
    said = listed(monkeypatch, "minionpy", "optimizers", "minion", "--search", "shade")
    assert "minion:LSHADE the minion optimizers need minionpy; install it with: pip install" in said
    assert "minion:ABC" not in said
