"""The performance page has what the scripts measured, and nothing else."""

import json
import shlex
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

ROOT = Path(__file__).parents[1]
MEASURED = json.loads((ROOT / "docs" / "reference" / "performance.json").read_text(encoding="utf-8"))


def test_every_script_has_its_rows_and_every_row_its_script():
    scripts = {path.stem for path in (ROOT / "performance").glob("[a-z]*.py")}
    assert {row["script"] for row in MEASURED["rows"]} == scripts
    for row in MEASURED["rows"]:
        program, script, *_ = shlex.split(row["command"])
        assert (program, (ROOT / script).is_file()) == ("python", True)
        assert row["measured"]
        assert row["value"]


def test_the_numbers_are_of_a_whole_run():
    assert not MEASURED["quick"]


def test_the_page_is_made_of_them():
    spec = spec_from_file_location("pages", ROOT / "docs" / "extensions" / "pages.py")
    pages = module_from_spec(spec)
    spec.loader.exec_module(pages)
    made = pages.performance(MEASURED)
    assert made.count("\n| ") == len(MEASURED["rows"]) + 2
    assert "mean nothing" not in made
    assert "mean nothing" in pages.performance(MEASURED | {"quick": True})
