"""Finding plug-ins, and refusing wrong ones."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

import bench
from bench import BenchError, load_optimizer, load_problem
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
        (lambda: load_optimizer("gwo:x"), "no Optimizer subclass, nor a family's member"),
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


def test_two_plugins_of_one_name_are_refused_by_name(install):
    for i in (1, 2):
        install(f"package{i}", "bench.optimizers", {"twin": "Thing"}, place=f"{i}")
    with pytest.raises(
        BenchError, match=r"two plug-ins of bench\.optimizers are called 'twin'.*package\d:.*package\d:"
    ):
        registry.entries("optimizers")


@pytest.mark.parametrize("name", ["optimizers", "problems"])
def test_a_foreign_module_of_a_generic_name_is_refused_at_start_up(tmp_path, name):
    (tmp_path / f"{name}.py").write_text("")
    first = os.environ | {"PYTHONPATH": str(tmp_path)}
    done = subprocess.run([sys.executable, "-m", "bench", "list"], env=first, capture_output=True, text=True)
    assert done.returncode == 2
    assert f"the module '{name}' found at" in done.stderr
    assert "Traceback" not in done.stderr


def test_members_of_built_in_families_are_near_names_too():
    with pytest.raises(BenchError, match="unknown optimizer 'Basinhopping'; did you mean 'scipy:basinhopping'"):
        load_optimizer("Basinhopping")
