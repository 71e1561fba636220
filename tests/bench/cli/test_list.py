"""What ``bench list`` prints about optimizers: lineage, parameters, families, and what failed to load."""

import json

import pytest

from bench import BenchError, Study
from bench.plugins import catalogue, registry


def test_an_optimizer_is_listed_with_its_lineage(bench_here):
    done = bench_here("list", "optimizers")
    text = " ".join(done.stdout.split())
    assert done.returncode == 0
    assert "paper: Mirjalili et al., 2014, Grey Wolf Optimizer, doi:10.1016/j.advengsoft.2013.12.007" in text
    assert "agents=30 (>= 3), handling='repair' ('repair' | 'box'), variant='code' ('code' | 'cascade')" in text
    assert "package: testing-plugins 1.0" in text


def test_a_plugin_that_fails_to_import_is_named_and_hides_no_other(bench_here):
    text = " ".join(bench_here("list", "optimizers").stdout.split())
    assert "'broken' of bench.optimizers (testing_plugins_missing:Nothing) failed to load: ModuleNotFoundError" in text
    assert "hill-climber A (1+1)-ES" in text


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
    assert "unknown kind 'problem'; did you mean 'problems'?" in done.stderr


def test_a_family_lists_its_members(bench_here):
    done = bench_here("list", "scipy")
    assert done.returncode == 0
    for name in ("differential_evolution", "dual_annealing", "shgo", "direct", "basinhopping"):
        assert f"scipy:{name}" in done.stdout
        assert f"scipy:{name}" in bench_here("list", "optimizers").stdout


def test_what_all_members_share_is_printed_once(bench_here):
    said = bench_here("list", "scipy").stdout
    assert said.count("code: scipy ") == said.count("family: scipy") == 1
    assert said.index("all of scipy") < said.index("code: scipy ") < said.index("scipy:basinhopping")
    assert said.count("parameters: ") == 5


def test_an_unknown_kind_is_refused(bench_here):
    done = bench_here("list", "optimisers")
    assert done.returncode == 2
    assert "unknown kind 'optimisers'; did you mean 'optimizers'?" in done.stderr


def test_a_record_of_what_cannot_be_loaded_says_why():
    with pytest.raises(BenchError, match="failed to load"):
        catalogue.record("broken")
