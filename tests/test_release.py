"""What a release is made of agrees: pyproject.toml, the conda recipe, the changelog and the licences.

``nox -s release`` builds it and tries it.
"""

import importlib.util
import re
import tomllib
from pathlib import Path

import pytest
import yaml

import bench

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.fixture(scope="module")
def release():
    spec = importlib.util.spec_from_file_location("release", ROOT / "tools" / "release.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


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


@pytest.mark.parametrize(
    ("text", "dated"),
    [
        ("# Changelog\n\n## 1.2.0 - 2026-01-31\n\n- A.\n", True),
        ("## 1.2.0\n\n- A.\n", False),
        ("## 1.2.0 - YYYY-MM-DD\n\n- A.\n", False),
        ("## 1x2.0 - 2026-01-31\n", False),
    ],
)
def test_a_release_needs_a_dated_entry(release, tmp_path, text, dated):
    (tmp_path / "CHANGELOG.md").write_text(text)
    found = [sentence.split(";")[0] for sentence in release.changelog_problems(tmp_path, "1.2.0")]
    assert found == [] if dated else ["CHANGELOG.md has no line '## 1.2.0 - YYYY-MM-DD'"]


@pytest.mark.parametrize(
    ("text", "plain", "extra"),
    [
        ("MIT", "", ""),
        ("BSD-3-Clause AND 0BSD AND MIT AND Zlib AND CC0-1.0", "", ""),
        ("Mozilla Public License 2.0 (MPL 2.0)", "", ""),
        ("LGPL-2.1-or-later", "", ""),
        ("GNU Lesser General Public License v3 (LGPLv3)", "", ""),
        ("GNU General Public License v3 (GPLv3)", "an extra only", ""),
        ("GPL-2.0-or-later", "an extra only", ""),
        ("GPL-2.0-only", "cannot be combined", "cannot be combined"),
        ("GPL-2.0-only OR MIT", "", ""),
        ("MIT AND GPL-2.0-only", "cannot be combined", "cannot be combined"),
        ("AGPL-3.0-only", "cannot be combined", "cannot be combined"),
        ("UNKNOWN", "which is unknown", "which is unknown"),
        ("Source available", "which is unknown", "which is unknown"),
    ],
)
def test_a_licence_that_is_unknown_or_cannot_be_combined_is_refused(release, text, plain, extra):
    for only_in_extra, said in ((False, plain), (True, extra)):
        sentence = release.licence_problem("thing", text, only_in_extra)
        assert bool(sentence) == bool(said)
        assert said in sentence
