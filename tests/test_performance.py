"""The performance page has what the scripts measured, and nothing else."""

import json
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
MEASURED = json.loads((ROOT / "docs" / "reference" / "performance.json").read_text(encoding="utf-8"))


def loaded(path):
    spec = spec_from_file_location(path.stem, path)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("before", "now", "times"),
    [
        ("58 s, at most 907 MB, a page of 10.2 MB", "58 s, at most 1,814 MB, a page of 10.2 MB", 2),
        ("2.4 us, 1.7 times the sphere itself", "3.6 us, 9 times the sphere itself", 1.5),
        ("31 s", "15.5 s", 0.5),
        ("68 and 72 MB", "68 and 72 MB", 1),
        ("160 times", "80 times", 1),
        ("31 s", "31 ms", 1),
        ("none", "31 s", 1),
    ],
)
def test_a_row_grows_by_its_time_or_memory_that_grew_most(before, now, times):
    assert loaded(ROOT / "performance" / "_rows.py").growth(before, now) == pytest.approx(times)


def test_the_page_is_made_of_them():
    pages = loaded(ROOT / "docs" / "extensions" / "pages.py")
    made = pages.performance(MEASURED)
    assert made.count("\n| ") == len(MEASURED["rows"]) + 2
    assert "mean nothing" not in made
    assert "mean nothing" in pages.performance(MEASURED | {"quick": True})
