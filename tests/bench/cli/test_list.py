"""What ``bench list`` prints about optimizers: lineage, parameters, families, and what failed to load."""

import json
import sys

import pytest
from typer.testing import CliRunner

from bench import BenchError, Study
from bench.cli.app import app
from bench.plugins import catalogue, registry


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


def test_a_family_without_names_says_how_it_is_used():
    shown = " ".join(CliRunner().invoke(app, ["list", "command"]).stdout.split())
    assert "command:./mine' runs the program ./mine" in shown
    assert "what it is" not in shown  # the head of a table


@pytest.mark.slow
def test_the_list_as_json_holds_every_optimizer(bench_here):
    listed = {each["name"]: each for each in json.loads(bench_here("list", "--json", "optimizers").stdout)}
    assert listed["gwo"]["parameters"][0] == {
        "name": "agents", "default": 30, "kind": "int", "minimum": 3, "maximum": None,
    }  # fmt: skip
    assert "failed to load" in listed["broken"]["error"]
    assert listed["scipy:differential_evolution"]["family"] == "scipy"


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


def test_an_unknown_kind_is_refused_as_json_too(bench_here):
    done = bench_here("list", "--json", "problem")
    assert done.returncode == 2
    assert "no kind, family, suite or plug-in is called 'problem'; did you mean 'problems'?" in done.stderr


def test_a_family_lists_its_members(bench_here):
    done = bench_here("list", "scipy")
    assert done.returncode == 0
    for name in ("differential_evolution", "dual_annealing", "shgo", "direct", "basinhopping"):
        assert f"scipy:{name}" in done.stdout


def test_a_member_of_a_family_is_listed_with_its_parameters_and_what_is_not_mapped(bench_here):
    for words in (("scipy:shgo",), ("optimizers", "scipy:shgo")):
        text = " ".join(bench_here("list", *words).stdout.split())
        assert "paper Endres et al., 2018" in text
        assert "iters=1 (>= 1)" in text
        assert "not mapped values above 1e+100" in text
    assert "scipy has no optimizer 'shg'; did you mean 'shgo'?" in bench_here("list", "scipy:shg").stderr


def test_an_optimizer_that_cannot_be_loaded_is_refused(bench_here):
    done = bench_here("list", "broken")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "failed to load: ModuleNotFoundError" in done.stderr


def test_an_unknown_kind_is_refused(bench_here):
    done = bench_here("list", "optimisers")
    assert done.returncode == 2
    assert "no kind, family, suite or plug-in is called 'optimisers'; did you mean 'optimizers'?" in done.stderr


@pytest.mark.parametrize("words", [["cec2022"], ["problems", "cec2022"]])
def test_a_suite_lists_its_functions_and_dimensions(bench_here, words):
    done = bench_here("list", *words)
    rows = [line.split("  ") for line in done.stdout.splitlines() if line.startswith("f")][1:]
    assert [row[0].strip() for row in rows] == [f"f{number:02}" for number in range(1, 13)]
    assert "f12       composition 4             10, 20      cec2022-f12-d10" in done.stdout


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


def test_another_family_of_problems_lists_its_names(bench_here):
    assert "signature-07" in bench_here("list", "signature").stdout.split()
    assert "recording:<name>" in bench_here("list", "recording").stdout.split()
    assert {"name": "signature-07"} in json.loads(bench_here("list", "signature", "--json").stdout)


def test_one_optimizer_is_listed_alone(bench_here):
    said = bench_here("list", "optimizers", "gwo").stdout
    assert "Mirjalili" in said
    assert "hill-climber" not in said


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["problems", "cec202"], "unknown family of problems 'cec202'; did you mean 'cec2020' or 'cec2022'?"),
        (["studies", "thesis"], "'studies' has no families or suites; leave out 'thesis'"),
    ],
)
def test_a_second_word_must_be_a_family(bench_here, words, sentence):
    done = bench_here("list", *words)
    assert (done.returncode, done.stderr) == (2, f"bench: {sentence}\n")


def test_a_record_of_what_cannot_be_loaded_says_why():
    with pytest.raises(BenchError, match="failed to load"):
        catalogue.record("broken")


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


def test_a_search_without_a_match_is_an_error(bench_here):
    done = bench_here("list", "studies", "--search", "nowhere")
    assert (done.returncode, done.stderr) == (2, "bench: no plug-in has 'nowhere' in its name or description\n")


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
