import hashlib
import json
from pathlib import Path

from bench import Results, write_report
from bench.report.interactive import library
from bench.report.interactive.part import as_json, explorer
from bench.topics.explore.explore import look_further
from bench.topics.findings import Findings


def test_json_cannot_end_its_element_and_reads_back():
    text = "</script><!--\u2028\u2029&amp; \ud7ff"
    assert json.loads(as_json([text])) == [text]
    assert not set("<>&\u2028\u2029") & set(as_json([text]))


def test_a_script_cannot_end_its_element():
    assert all("</script" not in each and "<!--" not in each for each in (library.library(), explorer()))


def test_the_same_findings_give_the_same_bytes(findings):
    assert look_further(findings) == look_further(findings)


def test_a_study_without_trials_or_with_too_many_cells_says_so(findings, make, tmp_path, monkeypatch):
    empty = make(tmp_path / "empty", problems=("p",), skip=[("p", each) for each in "abc"])
    assert look_further(Findings(Results(empty))).hint == "Without a trial there is nothing to look into."
    monkeypatch.setattr("bench.topics.explore.explore.MOST_CELLS", 0)
    assert "has no interactive part" in look_further(findings).hint


def test_a_report_has_it_after_the_first_part_and_in_the_contents(make, read, tmp_path):
    page = read(write_report(make(tmp_path / "s", problems=("p",), optimizers=("a",), trials=1)))
    assert page.texts("h2")[1] == "Look further"
    assert page.texts("a", href="#look-further") == ["Look further"]
    assert page.tags.count("script") == 4


def test_the_library_is_what_npm_has_with_its_licenses():
    folder = Path(library.__file__).with_name("vega")
    assert {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in library.SCRIPTS} == (
        library.SCRIPTS
    )
    assert {path.name for path in folder.iterdir()} == {"LICENSES", *library.SCRIPTS}
    assert library.library().startswith("/*\nThe three scripts")
    assert library.library().count("*/", 0, 40_000) == 1  # no license ends the comment
