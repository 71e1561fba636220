"""Finding plug-ins, and refusing wrong ones."""

import os
import subprocess
import sys

import pytest

from bench import BenchError, load_optimizer, load_problem
from bench.plugins import registry


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
        (lambda: load_optimizer("gwo", agents=True), "must be a whole number, not True"),
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
    with pytest.raises(BenchError, match=r"'broken' of bench\.optimizers .*failed to load"):
        load_optimizer("broken")


def test_two_plugins_of_one_name_are_refused_by_name(install):
    for i in (1, 2):
        install(f"package{i}", "bench.optimizers", {"twin": "Thing"}, place=f"{i}")
    with pytest.raises(
        BenchError, match=r"two plug-ins of bench\.optimizers are called 'twin'.*package\d:.*package\d:"
    ):
        registry.entries("optimizers")


@pytest.mark.sampled(1)
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
