"""What a report reads of optimizers: of every one that can be loaded, and no stranger's code runs in the report."""

import os

import pytest

from bench import Study, load_optimizer
from bench.execution.descriptions import Description, describe

CODE = """
import os
from dataclasses import dataclass
from pathlib import Path
import bench

Path(__file__).with_suffix(".pid").write_text(str(os.getpid()))

@dataclass(frozen=True)
class Mine(bench.Optimizer):
    bibtex = {bibtex}
    agents: int = 7
    handling = "mirror"

    def minimize(self, objective, rng):
        {deed}

{deed}
"""


@pytest.fixture
def file(tmp_path):
    """Return a function that writes an optimizer's file and returns its name."""

    def write(name, bibtex, deed="pass"):
        path = tmp_path / f"{name}.py"
        path.write_text(CODE.format(bibtex=repr(bibtex), deed=deed))
        return f"{path}:Mine"

    return write


def described(*names, sandbox=None, **options):
    optimizers = [{"name": name, "label": str(number), **options} for number, name in enumerate(names)]
    study = Study.from_dict({"name": "s", "problems": [{"name": "sphere-2"}], "optimizers": optimizers})
    return [*describe(study, sandbox).values()]


def cited(*names, sandbox=None):
    return [each.bibtex for each in described(*names, sandbox=sandbox)]


def test_each_optimizer_s_own_text_is_read(file, testing_plugins):
    expected = [load_optimizer("gwo").bibtex, "@misc{mine}", "", "", ""]
    assert expected[0].startswith("@")
    assert cited("gwo", file("mine", "@misc{mine}"), "hill-climber", "gone.py:Mine", "broken") == expected


def test_what_is_no_text_or_ends_its_process_costs_only_itself(file, testing_plugins):
    names = [file("odd", 5), file("deadly", "@misc{b}", "os._exit(0)"), file("sound", "@misc{c}")]
    assert cited(*names) == ["", "", "@misc{c}"]


def test_no_file_is_imported_here(file, tmp_path, testing_plugins):
    assert cited(file("mine", "@misc{mine}")) == ["@misc{mine}"]
    assert int((tmp_path / "mine.pid").read_text()) != os.getpid()


def test_a_stranger_s_is_not_read_without_the_sandbox_that_the_run_had(file, tmp_path, testing_plugins):
    assert cited("gwo", file("mine", "@misc{mine}"), sandbox="none")[1] == ""
    assert not (tmp_path / "mine.pid").exists()


def test_parameters_and_fixed_conditions_are_read_as_texts(file, testing_plugins):
    mine, gone = described(file("mine", ""), "gone.py:Mine", agents=9)
    assert mine == Description("", {"agents": "9", "handling": "mirror"}, {"agents": "7", "handling": "mirror"})
    assert gone == Description()
    gwo, cma = described("gwo", "cma-es", agents=9)
    assert gwo.values == {"agents": "9", "handling": "repair", "variant": "code", "start": "random"}
    assert cma.defaults == {
        "agents": "null",
        "handling": "repair",
        "start": "random",
        "sigma": "0.25",
        "active": "true",
    }
