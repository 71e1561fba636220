"""The workflows test what pyproject.toml claims, and call sessions that nox has; 'nox -s workflows' checks the rest."""

import re
import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]
WORKFLOWS = {file.stem: yaml.safe_load(file.read_text(encoding="utf-8")) for file in ROOT.glob(".github/workflows/*")}
SYSTEMS = {"POSIX :: Linux": "ubuntu-latest", "MacOS": "macos-latest", "Microsoft :: Windows": "windows-latest"}


@pytest.fixture(scope="module")
def classifiers():
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["classifiers"]


@pytest.fixture(scope="module")
def matrix():
    return WORKFLOWS["tests"]["jobs"]["tests"]["strategy"]["matrix"]


def test_every_version_of_python_is_tested(classifiers, matrix):
    named = [each.split(" :: ")[-1] for each in classifiers if re.search(r":: 3\.\d+$", each)]
    assert matrix["python-version"] == named


def test_the_next_version_of_python_is_tried_and_not_claimed(classifiers, matrix):
    (tried,) = matrix["include"]
    following = f"3.{1 + int(matrix['python-version'][-1].removeprefix('3.'))}"
    assert tried == {"os": "ubuntu-latest", "python-version": following, "untried": True}
    assert not any(each.endswith(f":: {following}") for each in classifiers)
    assert WORKFLOWS["tests"]["jobs"]["tests"]["continue-on-error"] == "${{ matrix.untried == true }}"


def test_a_system_is_claimed_only_where_it_is_tested(classifiers, matrix):
    named = [each.partition(" :: ")[2] for each in classifiers if each.startswith("Operating System")]
    assert "POSIX :: Linux" in named
    assert {SYSTEMS[each] for each in named} <= set(matrix["os"])


def test_every_session_that_is_called_exists():
    text = (ROOT / "noxfile.py").read_text(encoding="utf-8")
    sessions = set(re.findall(r"^@nox\.session.*\ndef (\w+)\(", text, re.MULTILINE))
    steps = [step for each in WORKFLOWS.values() for job in each["jobs"].values() for step in job["steps"]]
    called = [re.findall(r"nox -s ([\w ]+)$", step.get("run", "")) for step in steps]
    called = {name for names in called for each in names for name in each.split()}
    assert called == {"tests", "lowest", "nightly", "lint", "types", "workflows", "docs"}
    assert called <= sessions
