"""The studies of benchmark suites."""

import tomllib
from pathlib import Path

import pytest

from bench import Study, load_optimizer
from problems import studies

SUITES = studies.bbob, studies.bbob_quick, studies.cec2022


@pytest.mark.parametrize("path", SUITES, ids=lambda path: path.stem)
def test_the_studies_of_suites_have_strong_and_weak_baselines_that_load(path):
    labels = [entry.label for entry in Study.load(path).optimizers]
    assert {"bipop-cma-es", "minion:LSHADE", "scipy:differential_evolution", "random-search"} <= set(labels)
    for label in labels:
        load_optimizer(label)


def test_the_extra_of_the_suites_installs_what_their_optimizers_need():
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))
    extras = project["project"]["optional-dependencies"]
    assert set(extras["minion"]) <= set(extras["suites"])
