"""How optimizers describe themselves: read where a study is checked, noted by the run, used by the report alone."""

import shutil

import pytest

from bench import Results, Study, load_optimizer, run, write_report
from bench.execution.job import Task
from bench.execution.supervisor import check
from bench.study.descriptions import Description, noted

CODE = """
import os
from dataclasses import dataclass
from pathlib import Path
import bench

Path(__file__).with_suffix(".pid").write_text(str(os.getpid()))

@dataclass(frozen=True)
class Mine(bench.Optimizer):
    agents: int = 7
    handling = "mirror"

    @property
    def bibtex(self):
        return {bibtex}

    def minimize(self, objective, rng):
        pass
"""


@pytest.fixture
def file(tmp_path):
    """Return a function that writes an optimizer's file and returns its name."""

    def write(name, bibtex):
        path = tmp_path / f"{name}.py"
        path.write_text(CODE.format(bibtex=bibtex))
        return f"{path}:Mine"

    return write


def described(*names, **options):
    optimizers = [{"name": name, "label": str(number), **options} for number, name in enumerate(names)]
    study = Study.from_dict({"name": "s", "problems": [{"name": "sphere-2"}], "optimizers": optimizers})
    return [*check(Task.of(study)).descriptions.values()]


def cited(*names):
    return [each.bibtex for each in described(*names)]


def test_each_optimizer_s_own_text_is_read(file, testing_plugins):
    expected = [load_optimizer("gwo").bibtex, "@misc{mine}", ""]
    assert expected[0].startswith("@")
    assert cited("gwo", file("mine", "'@misc{mine}'"), "hill-climber") == expected


WORK = "@misc{mine2020,\n  author = {Doe, Jane},\n  title = {Mine},\n  year = {2020},\n}"


@pytest.fixture(scope="module")
def ran(tmp_path_factory, testing_plugins):
    """Return the folder of a run of a stranger's optimizer beside a built-in one; no test changes it."""
    place = tmp_path_factory.mktemp("described")
    (place / "mine.py").write_text(CODE.format(bibtex=repr(WORK)))
    study = Study.from_dict({
        "name": "s", "trials": 1, "budget": 30, "problems": [{"name": "sphere-2"}],
        "optimizers": [{"name": f"{place}/mine.py:Mine", "label": "mine"}, {"name": "gwo", "agents": 9}],
    })  # fmt: skip
    run(study, place / "out", n_jobs=1)
    return place / "out"


@pytest.fixture
def made(ran, tmp_path):
    """Return a copy of that folder."""
    return shutil.copytree(ran, tmp_path / "out")


def test_a_run_notes_what_a_report_reads_and_the_report_imports_no_stranger(ran, made):
    imported = ran.parent / "mine.pid"
    imported.unlink()
    results = Results(made)
    mine, gwo = noted(results.study, results.descriptions).values()
    assert mine == Description(WORK, {"agents": "7", "handling": "mirror"}, {"agents": "7", "handling": "mirror"})
    assert gwo.values["agents"] == "9"
    page = write_report(made, n_jobs=1)
    assert "Doe, Jane" in (page.parent / "references.bib").read_text(encoding="utf-8")
    assert not imported.exists()
