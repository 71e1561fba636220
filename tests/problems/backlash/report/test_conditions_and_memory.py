"""Unequal conditions, and the memory of a search, of any study."""

import subprocess
import sys
from pathlib import Path

import pytest

from bench import Study
from bench.study import Entry
from problems.backlash.report import fitting_errors, resources


def alike(name, agents, **options):
    return Entry(name, f"{name} {agents}", {"agents": agents, "handling": "repair", **options})


BOTH = [alike("cma-es", 30, start="random"), alike("gwo", 30)]


def test_table_7_2_takes_the_thesis_s_population_of_several():
    labels = fitting_errors.algorithms(Study.load("thesis-equal"))
    assert labels == {name: f"{name} 300" for name in ("alo", "goa", "da", "gwo", "cma-es")}


def test_the_memory_of_known_optimizers_and_agents_is_shown():
    study = Study.load("thesis")
    assert resources.memory_of(study).index.tolist() == [entry.label for entry in study.optimizers]
    assert resources.memory_of(Study.load("bbob-quick")).empty
    optimizers = (*BOTH, Entry("gwo", "other", {"agents": 31}))
    (section,) = resources.sections(Study("s", (Entry("signature-12", "signature-12"),), optimizers, trials=1))
    assert section.items[0].frame.index.tolist() == ["cma-es 30", "gwo 30"]
    assert "200 kB with gwo 30 and 380 kB with cma-es 30" in section.text[0]


@pytest.mark.parametrize("name", ["gwo", pytest.param("cma-es", marks=pytest.mark.slow)])
def test_the_memory_that_reports_print_is_what_is_measured(name):
    code = f"import memory; print(1e3 * memory.memory({name!r}, 300, 60_000, 0, True)[1])"
    place = Path(__file__).resolve().parents[4] / "performance"
    done = subprocess.run([sys.executable, "-c", code], cwd=place, capture_output=True, text=True, check=True)
    printed = resources.measured().set_index(["optimizer", "agents"]).loc[(name, 300), "traced_kb"]
    assert float(done.stdout) == pytest.approx(printed, rel=0.3)


def test_a_study_of_unequal_conditions_names_the_one_of_equal_ones():
    assert (
        "the study thesis-equal gives all the same handling and start"
        in fitting_errors.unequal(Study.load("thesis"))[0]
    )
    assert fitting_errors.unequal(Study.load("thesis-equal")) == ()
