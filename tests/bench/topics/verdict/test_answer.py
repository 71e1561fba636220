"""The answer of a report, as a terminal shows it."""

import json
from io import StringIO

from rich.console import Console

from bench.cli.answer import as_lines, read
from bench.results.results import StoredResults
from bench.storage.folder import ANSWER
from bench.topics.findings import Findings
from bench.topics.verdict import section as verdict
from bench.topics.verdict.answer import MOST, answer


def noted(folder):
    findings = Findings(StoredResults(folder))
    return answer(findings, verdict.section(findings))


def lines(answer, width=80):
    console = Console(width=width, file=StringIO())
    console.print(as_lines(answer))
    return console.file.getvalue().splitlines()


def test_it_has_the_first_sentence_and_the_optimizers_in_their_order(make, tmp_path):
    found = noted(make(tmp_path / "s"))
    assert found["sentence"] == "a ends lowest on these 2 problems at 100 evaluations."
    assert [(row[0], row[1], row[2]) for row in found["rows"]] == [
        ("a", "1.00", "2 of 2"), ("b", "2.00", "0 of 2"), ("c", "3.00", "0 of 2"),
    ]  # fmt: skip
    assert found["trials"] == 2 * 3 * 8
    assert any(line.split()[:2] == ["optimizer", "mean"] for line in lines(found))


def test_a_selection_names_what_it_leaves_out_in_its_answer_and_among_the_limits_of_its_verdict(make, tmp_path):
    findings = Findings(StoredResults(make(tmp_path / "s")).select(optimizers=["a", "c"], problems="q"))
    section = verdict.section(findings)
    found = answer(findings, section)
    assert found["selection"] == (
        "Selected from 3 optimizers and 2 problems after the results were seen; left out: 1 optimizer (b) and 1 "
        "problem (p)."
    )
    assert found["trials"] == 1 * 2 * 8
    assert lines(found, width=200)[1] == found["selection"]
    limits = next(card for card in section.cards if card.title == "What may not be claimed")
    assert limits.text[0].startswith(found["selection"])
    assert noted(make(tmp_path / "t"))["selection"] == ""


def test_many_optimizers_of_long_names_fit_a_narrow_terminal(make, tmp_path):
    names = tuple(f"an-optimizer-with-a-long-name-and-its-options[{number}]" for number in range(MOST + 3))
    found = noted(make(tmp_path / "s", optimizers=names, trials=3))
    assert len(found["rows"]) == MOST
    assert found["more"] == "and 3 other optimizers"
    assert max(map(len, lines(found))) <= 80
    assert len({name for name, *_ in found["rows"]}) == MOST
    assert found["rows"][0][0] == "an-optimizer-with-a-l…ts-options[0]"


def test_without_a_comparison_it_states_why(make, tmp_path):
    found = noted(make(tmp_path / "s", optimizers=("a",)))
    assert (found["sentence"], found["rows"]) == ("There is nothing to compare: a is the only optimizer.", [])
    assert lines(found) == ["There is nothing to compare: a is the only optimizer."]


def test_what_is_no_answer_is_read_as_none(tmp_path):
    assert read(tmp_path) == {}
    for text in ("[", "[]", json.dumps({"rows": 3}), "[" * 100_000):
        (tmp_path / ANSWER).write_text(text)
        assert read(tmp_path) == {}
