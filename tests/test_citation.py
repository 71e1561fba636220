"""CITATION.cff is valid CFF 1.2.0 and agrees with pyproject.toml."""

import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def citation():
    return yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


def test_it_holds_what_the_format_requires(citation):
    assert citation["cff-version"] == "1.2.0"
    assert {"message", "title", "authors"} <= citation.keys()
    assert citation.keys() <= {
        "cff-version", "message", "type", "title", "version", "license", "authors", "abstract", "keywords", "references"
    }  # fmt: skip
    for work in (citation, *citation["references"]):
        assert {"type", "title", "authors"} <= work.keys()
        assert all(author.keys() <= {"name", "family-names", "given-names"} for author in work["authors"])
    assert (citation["type"], citation["references"][0]["type"]) == ("software", "thesis")


def test_it_agrees_with_the_package(citation):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert citation["version"] == project["version"] == version("backlash-bench")
    assert citation["title"] == project["name"]
    assert citation["license"] == project["license"]
    assert citation["keywords"] == project["keywords"]
    assert project["description"] == citation["abstract"]
