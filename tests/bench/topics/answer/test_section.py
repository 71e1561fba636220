"""The answer: its headline, its lines and its picture, for a leader and for a subject."""

from dataclasses import replace

import pytest

from bench import Results
from bench.topics.answer import section as answer
from bench.topics.answer import words
from bench.topics.findings import Findings


def findings(folder, subject=""):
    results = Results(folder)
    results.study = replace(results.study, subject=subject)
    return Findings(results)


@pytest.fixture(scope="module")
def folder(make, tmp_path_factory):
    """Return a folder in which a finds about 5, b about 6 and c about 7."""
    return make(tmp_path_factory.mktemp("answer") / "s")


def said(found):
    return {line.label: line.text for line in answer.lines(found)}


@pytest.mark.parametrize(("subject", "headline"), [
    ("a", "a beats 2 of 2 rivals on these 2 problems."),
    ("b", "b beats 1 of 2 rivals, loses to a on these 2 problems."),
    ("c", "c loses to a and b on these 2 problems."),
])  # fmt: skip
def test_with_a_subject_every_line_is_about_it(folder, subject, headline):
    found = findings(folder, subject)
    assert answer.headline(found) == headline
    lines = said(found)
    assert all(subject in lines[label] for label in ("by how much", "at what cost"))
    assert lines["where"].startswith("first on ")


def test_a_filled_point_never_crosses_the_line_and_an_open_one_always_does(make, folder, tmp_path):
    alike = make(tmp_path / "s", changes={"b": {"fun": 5.0}})
    for found in (findings(folder), findings(folder, "b"), findings(alike), findings(alike, "c")):
        rows = answer.section(found).items[0].data
        crosses = (rows["low"] <= 0.5) & (rows["high"] >= 0.5)
        assert (crosses == (rows["outcome"] == "open")).all()


def test_without_a_winner_the_rivals_that_are_open_are_named(make, tmp_path):
    found = findings(make(tmp_path / "s", changes={"a": {"fun": 5.0}, "b": {"fun": 5.0}}))
    assert answer.headline(found) == "No winner on these 2 problems: a and b share the first place."
    one = findings(make(tmp_path / "one", trials=1))
    assert answer.headline(one).endswith("is first, and single runs cannot be tested.")
    assert said(one)["how sure"] == words.chance_order()
    assert "by how much" not in said(one)


def test_where_nothing_can_be_compared_it_states_why(make, tmp_path):
    lost = [(problem, optimizer) for problem in "pq" for optimizer in "abc"]
    assert answer.section(findings(make(tmp_path / "s", fail=lost))).text == (
        "There is nothing to compare: no trial finished.",
    )
    alone = answer.section(findings(make(tmp_path / "alone", optimizers=("b",))))
    assert alone.text == ("There is nothing to compare: b is the only optimizer.",)
