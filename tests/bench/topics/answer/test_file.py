"""The answer of a report, as a terminal shows it."""

import json
from io import StringIO

from rich.console import Console

from bench.cli.answer import as_lines, show
from bench.results.results import StoredResults
from bench.storage.folder import ANSWER, Folder
from bench.topics.answer.file import answer
from bench.topics.answer.section import lines
from bench.topics.findings import Findings


def noted(folder):
    findings = Findings(StoredResults(folder))
    return answer(findings, lines(findings))


def printed(answer, width=80):
    console = Console(width=width, file=StringIO())
    console.print(as_lines(answer))
    return console.file.getvalue().splitlines()


def test_it_has_the_headline_the_lines_and_the_optimizers_in_their_order(make, tmp_path):
    found = noted(make(tmp_path / "s"))
    assert found["sentence"] == "a ends lowest on these 2 problems."
    assert [label for label, _ in found["lines"]] == ["where", "by how much", "how sure", "at what cost"]
    assert [(row[0], row[1], row[2]) for row in found["rows"]] == [
        ("a", "1.00", "2 of 2"), ("b", "0.50", "0 of 2"), ("c", "0.00", "0 of 2"),
    ]  # fmt: skip
    assert found["state"] == Folder(tmp_path / "s").store.state() != ""
    assert any(line.split()[:2] == ["optimizer", "chance"] for line in printed(found))


def test_a_selection_names_what_it_leaves_out(make, tmp_path):
    findings = Findings(StoredResults(make(tmp_path / "s")).select(optimizers=["a", "c"], problems="q"))
    found = answer(findings, lines(findings))
    assert found["selection"] == (
        "Selected from 3 optimizers and 2 problems after the results were seen; left out: 1 optimizer (b) and 1 "
        "problem (p)."
    )
    assert found["state"] == ""
    assert found["selection"] in printed(found, width=200)
    assert noted(make(tmp_path / "t"))["selection"] == ""


def test_an_older_report_is_called_old_and_what_the_results_say_now_is_printed(make, tmp_path):
    folder, old = make(tmp_path / "s"), "the report is older than the trials; write it again: bench report"

    def said():
        show(folder, console := Console(width=200, file=StringIO()))
        return console.file.getvalue()

    assert "a ends lowest on these 2 problems." in said()
    file, now = folder / ANSWER, noted(folder)
    file.write_text(json.dumps(now | {"sentence": "As it was noted."}))
    assert "As it was noted." in said()
    with Folder(folder).store.writer() as writer:
        writer.record("history", {"look": {"outcome": "undecided"}})
    assert "As it was noted." in said()  # a look changes no result
    assert old not in said()
    file.write_text(json.dumps(now | {"sentence": "A stale verdict.", "state": "other trials"}))
    assert "A stale verdict." not in said()
    assert f"{old} {folder}" in said()
