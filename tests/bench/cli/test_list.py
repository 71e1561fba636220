"""What ``bench list`` prints about optimizers: lineage, parameters, families, and what failed to load."""

import json
import sys

import pytest
from typer.testing import CliRunner

from bench import Study
from bench.cli.app import app
from bench.plugins import registry


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


@pytest.mark.parametrize("kind", ["problems", "studies", "commands"])
def test_the_list_of_another_kind_as_json_holds_its_plugins(bench_here, kind):
    listed = {each["name"]: each for each in json.loads(bench_here("list", "--json", kind).stdout)}
    assert set(listed) == set(registry.entries(kind))
    assert all(set(each) <= {"name", "package", "about", "error"} for each in listed.values())
    name, start, about = {
        "problems": ("signature", "backlash-bench ", "signature-01 … signature-20"),
        "studies": ("thesis", "backlash-bench ", Study.load("thesis").title),
        "commands": ("data", "backlash-bench ", "published recordings"),
    }[kind]
    assert listed[name]["package"].startswith(start)
    assert about in listed[name]["about"]


def test_a_member_of_a_family_is_listed_with_its_parameters_and_what_is_not_mapped(bench_here):
    for words in (("scipy:shgo",), ("optimizers", "scipy:shgo")):
        text = " ".join(bench_here("list", *words).stdout.split())
        assert "paper Endres et al., 2018" in text
        assert "iters=1 (>= 1)" in text
        assert "not mapped values above 1e+100" in text
    assert "scipy has no optimizer 'shg'; did you mean 'shgo'?" in bench_here("list", "scipy:shg").stderr


def test_a_suite_with_instances_lists_their_number(bench_here):
    rows = [line.split() for line in bench_here("list", "problems", "bbob").stdout.splitlines()]
    assert ["f08", "Rosenbrock", "2,", "3,", "5,", "10,", "20,", "40", "1", "to", "15", "bbob-f08-d2-i1"] in rows
    listed = json.loads(bench_here("list", "problems", "bbob", "--json").stdout)
    first = {
        "function": "f01",
        "dimensions": [2, 3, 5, 10, 20, 40],
        "instances": 15,
        "name": "bbob-f01-d2-i1",
        "title": "sphere",
    }
    assert (len(listed), listed[0]) == (24, first)


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


def test_a_search_finds_functions_by_what_they_are_called(bench_here):
    said = bench_here("list", "problems", "--search", "rosenbrock").stdout
    assert "bbob-f08-d2-i1" in said
    assert "classical-rosenbrock-d2-i1" in said
    assert "bbob-f01-d2-i1" not in said


def test_a_suite_without_its_library_says_how_to_get_it(monkeypatch):
    said = listed(monkeypatch, "cocoex", "bbob")
    assert "f01 sphere" in said
    assert "needs cocoex; install it with: pip install 'backlash-bench[suites]'" in said


def test_a_list_fits_a_screen(bench_here):
    """Citations and parameters are printed on request only."""
    assert len(bench_here("list").stdout.splitlines()) < 24
    said = bench_here("list", "optimizers").stdout
    assert len(said.splitlines()) < 50
    assert "doi:" not in said
