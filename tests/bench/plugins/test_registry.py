"""Finding plug-ins, refusing wrong ones, and the contract's parameters."""

import ast
import subprocess
import sys
from dataclasses import dataclass
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Literal

import pytest

import bench
from bench import BenchError, Optimizer, load_optimizer, load_problem, parameter
from bench.plugins import registry

ROOT = Path(bench.__file__).parent


def test_bench_imports_neither_optimizers_nor_problems():
    for path in ROOT.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            modules = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                modules.append(node.module or "")
            assert not {"optimizers", "problems"} & {module.partition(".")[0] for module in modules}, path


@pytest.mark.parametrize(("package", "others"), [("optimizers", {"problems"}), ("problems", {"optimizers"})])
def test_plugins_do_not_import_each_other(package, others):
    for path in (ROOT.parent / package).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert (node.module or "").partition(".")[0] not in others, path


def test_every_group_of_the_contract_holds_a_built_in():
    for group in ("optimizers", "problems", "commands", "studies", "report_sections"):
        own = [entry for entry in registry.entries(group).values() if entry.dist.name == registry.DISTRIBUTION]
        assert own, group


def test_a_stranger_s_plugin_loads_as_a_built_in_does():
    assert type(load_optimizer("hill-climber", sigma=0.5)).__name__ == "HillClimber"
    assert load_optimizer("gwo", agents=12).agents == 12
    assert load_problem("sphere-3").dimension == 3


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: load_optimizer("gwp"), "unknown optimizer 'gwp'; did you mean 'gwo'?"),
        (lambda: load_optimizer("gwo", agentss=3), "no parameter 'agentss'; did you mean 'agents'?"),
        (lambda: load_optimizer("gwo", agents=1), "must be at least 3, not 1"),
        (lambda: load_optimizer("gwo", agents="many"), "must be a whole number, not 'many'"),
        (lambda: load_optimizer("gwo", agents=True), "must be a whole number, not True"),
        (lambda: load_optimizer("gwo", variant="codee"), "must be one of 'code', 'cascade'"),
        (
            lambda: load_optimizer("broken"),
            "'broken' of bench.optimizers (testing_plugins_missing:Nothing) failed to load",
        ),
        (lambda: load_optimizer("gwo:x"), "no Optimizer subclass, nor a family"),
        (lambda: load_optimizer("nobody:x"), "unknown optimizer 'nobody:x'"),
        (lambda: load_problem("signature-21"), "unknown problem 'signature-21'; did you mean 'signature-"),
        (lambda: load_problem("signature-12", units="rpm"), "no option 'units'; did you mean 'unit'?"),
        (lambda: load_problem("recording:"), "a recording needs a path"),
    ],
)
def test_one_sentence_names_what_is_wrong_and_what_is_near(call, said):
    with pytest.raises(BenchError) as caught:
        call()
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_broken_plugin_breaks_no_other():
    assert load_optimizer("hill-climber") is not None
    with pytest.raises(BenchError, match=r"'broken' of bench\.optimizers"):
        load_optimizer("broken")


def test_two_plugins_of_one_name_are_refused_by_name(monkeypatch):
    twins = [EntryPoint("twin", f"package{i}:Thing", "bench.optimizers") for i in (1, 2)]
    monkeypatch.setattr(registry, "entry_points", lambda group: twins)
    registry.entries.cache_clear()
    with pytest.raises(BenchError, match=r"two plug-ins of bench\.optimizers are called 'twin'.*package1:.*package2:"):
        registry.entries("optimizers")
    registry.entries.cache_clear()


@pytest.mark.parametrize("name", ["optimizers", "problems"])
def test_a_foreign_module_of_a_generic_name_is_refused_at_start_up(tmp_path, name):
    (tmp_path / f"{name}.py").write_text("")
    done = subprocess.run([sys.executable, "-m", "bench", "list"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2
    assert f"the module '{name}' found at" in done.stderr
    assert "Traceback" not in done.stderr


@dataclass(frozen=True)
class Sample(Optimizer):
    rate: float = parameter(0.5, minimum=0.0, maximum=1.0)
    mode: Literal["a", "b"] = "a"
    size: int | None = parameter(None, minimum=2)

    def minimize(self, objective, rng):
        """Do nothing."""


@pytest.mark.parametrize("options", [{"rate": 1}, {"rate": 0.0}, {"mode": "b"}, {"size": 2}, {"size": None}])
def test_parameters_in_range_are_taken(options):
    Sample(**options)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"rate": 1.5}, "'rate' of Sample must be from 0.0 to 1.0, not 1.5"),
        ({"rate": float("nan")}, "must be from 0.0 to 1.0, not nan"),
        ({"rate": "x"}, "must be a number"),
        ({"mode": "c"}, "must be one of 'a', 'b'"),
        ({"size": 1}, "must be at least 2, not 1"),
        ({"size": 2.5}, "must be a whole number or nothing"),
    ],
)
def test_parameters_out_of_range_are_named(options, said):
    with pytest.raises(BenchError) as caught:
        Sample(**options)
    assert said in str(caught.value)


def test_the_smallest_budget_is_one_generation():
    assert Sample().minimum_budget == 1
    assert load_optimizer("scatter", agents=7).minimum_budget == 7
    assert load_optimizer("cma-es").minimum_budget == 1
