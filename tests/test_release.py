"""What a release is made of agrees: pyproject.toml, the conda recipe, the changelog and the licences.

``nox -s release`` builds it and tries it.
"""

import re
import tomllib
from pathlib import Path

import pytest
import yaml

import bench

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.fixture(scope="module")
def recipe():
    return yaml.safe_load((ROOT / "conda" / "recipe.yaml").read_text(encoding="utf-8"))


def test_the_conda_recipe_says_what_pyproject_says(recipe):
    assert recipe["context"]["version"] == PROJECT["version"] == bench.__version__
    assert recipe["package"]["name"] == PROJECT["name"]
    named = {"matplotlib": "matplotlib-base"}  # the library without a window system
    needed = {"python": PROJECT["requires-python"]}
    for each in PROJECT["dependencies"]:
        name, bounds = re.fullmatch(r"([a-z0-9-]+)(.*)", each).groups()
        needed[named.get(name, name)] = bounds
    run = dict(each.split(" ", 1) for each in recipe["requirements"]["run"])
    assert run == needed
    entry_points = dict(each.split(" = ") for each in recipe["build"]["python"]["entry_points"])
    assert entry_points == PROJECT["scripts"]
    assert recipe["about"]["summary"] == PROJECT["description"]
    assert recipe["about"]["license"] == PROJECT["license"]


def test_the_citation_says_what_pyproject_and_the_changelog_say():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["cff-version"] == "1.2.0"
    assert [citation[key] for key in ("version", "title", "license", "keywords", "abstract")] == [
        PROJECT[key] for key in ("version", "name", "license", "keywords", "description")
    ]
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"## {PROJECT['version']} - {citation['date-released']}" in changelog.splitlines()
