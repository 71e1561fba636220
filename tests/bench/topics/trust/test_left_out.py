"""What is not compared, in one sentence each, and what a page then says."""

import pytest

from bench import Results
from bench.study import Entry, Study
from bench.topics.findings import Findings
from bench.topics.findings.selection import selection
from bench.topics.methods.methods import methods
from bench.topics.trust import section as trust

PROBLEMS = ["f1-d2-i1", "f1-d2-i2", "f8-d2-i1", "f8-d2-i2"]


FOUR, TWO = "3 optimizers and 4 problems", "3 optimizers and 2 problems"


@pytest.mark.parametrize(
    ("optimizers", "problems", "every", "missing"),
    [
        ("b", PROBLEMS, TWO, "2 optimizers (a and c)"),
        ("ab", PROBLEMS[:2], TWO, "1 optimizer (c) and 1 problem (f8-d2)"),
        ("abc", PROBLEMS[::2], TWO, "2 of 4 instances"),
        ("abc", PROBLEMS[::2], FOUR, "2 problems (f1-d2-i2 and f8-d2-i2)"),
    ],
)
def test_a_selection_names_what_is_left_out(optimizers, problems, every, missing):
    entries = [tuple(Entry("any", label) for label in labels) for labels in (PROBLEMS, "abc", problems, optimizers)]
    whole, shown = Study("s", *entries[:2]), Study("s", *entries[2:])
    assert selection(whole, shown, by_instance=every == FOUR) == (
        f"Selected from {every} after the results were seen; left out: {missing}."
    )
    assert selection(whole, whole, by_instance=every == FOUR) == ""


def said(section):
    return [f"{line.label}: {line.text}" for line in section.lines]


def test_a_problem_that_failed_makes_nobody_lose_and_is_named(make, tmp_path):
    """One trial of a survived: it was best on the problem, before."""
    raised = [("q", label, number) for label in "abc" for number in range(8) if (label, number) != ("a", 0)]
    found = Findings(Results(make(tmp_path / "s", raised=raised)))
    assert list(found.final.medians.index) == ["p"]
    section = trust.section(found)
    assert said(section)[0].startswith("not compared: The problem that failed is not compared")
    assert "q (in 23 of 24 trials)" in said(section)[0]
    assert section.lost == ""  # no optimizer lost a trial
    assert not any(line.startswith("failures") for line in said(section))
    text = methods(found).text
    assert "failed or found no finite value" not in text
    assert "Not compared, as the problem's own code raised in a trial: q." in text
