import json

import pytest

from bench import Results, write_report
from bench.report.findings import Findings
from bench.report.interactive import interactive, library, part
from bench.report.interactive.part import as_json, explorer
from bench.report.page import View, render
from bench.report.parts import Section


@pytest.fixture
def without(monkeypatch):
    """The optional package is not installed."""
    library._version.cache_clear()
    monkeypatch.setattr(library, "PACKAGE", "no-such-package")
    yield
    library._version.cache_clear()


def test_json_cannot_end_its_element_and_reads_back():
    text = "</script><!--\u2028\u2029&amp; \ud7ff"
    assert json.loads(as_json([text])) == [text]
    assert not set("<>&\u2028\u2029") & set(as_json([text]))


def test_a_script_cannot_end_its_element():
    assert all("</script" not in each and "<!--" not in each for each in (library.library(), explorer()))


def test_the_same_findings_give_the_same_bytes(findings):
    assert interactive(findings) == interactive(findings)


def test_without_the_package_there_is_a_hint_how_to_get_it(findings, read, without):
    further = interactive(findings)
    assert not further.scripts
    page = read(render("", "", [View("part.1", Section("Verdict"), [], [], [])], further=further))
    assert part.EXTRA in page.text
    assert page.tags.count("script") == 1
    assert page.texts("h2") == ["1 Verdict"]


def test_a_study_without_trials_or_with_too_many_cells_says_so(findings, make, tmp_path, monkeypatch):
    empty = make(tmp_path / "empty", problems=("p",), skip=[("p", each) for each in "abc"])
    assert interactive(Findings(Results(empty))).hint == "Without a trial there is nothing to look into."
    monkeypatch.setattr(part, "explore", lambda findings: None)
    assert "has no interactive part" in interactive(findings).hint


def test_a_report_has_it_after_the_first_part_and_in_the_contents(make, read, tmp_path):
    page = read(write_report(make(tmp_path / "s", problems=("p",), optimizers=("a",), trials=1)))
    assert page.texts("h2")[1] == "Look further"
    assert page.texts("a", href="#look-further") == ["Look further"]
    assert page.tags.count("script") == 4


def test_the_library_is_bundled_once_a_version(tmp_path, monkeypatch):
    monkeypatch.setenv("BENCH_CACHE", str(tmp_path))
    monkeypatch.setattr(library, "_bundled", lambda: "made();" + library._END)
    library.library.cache_clear()
    try:
        assert library.library() == "made();" + library._END
        (kept,) = tmp_path.iterdir()
        kept.write_text("kept();" + library._END)
        library.library.cache_clear()
        assert library.library().startswith("kept")
        kept.write_text("cut of")  # such as by a full disk
        library.library.cache_clear()
        assert library.library().startswith("made")
    finally:
        library.library.cache_clear()
