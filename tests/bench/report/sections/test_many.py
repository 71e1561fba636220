"""Sections of a study of many problems, or of many optimizers: what is said of all first, single ones folded away."""

import pytest

from bench import Results
from bench.report.findings import MANY_PROBLEMS, Findings
from bench.report.sections import anytime, comparison, datasets, verdict


@pytest.fixture(scope="module")
def few(make, tmp_path_factory):
    problems = tuple(f"p{number}" for number in range(MANY_PROBLEMS))
    return Findings(Results(make(tmp_path_factory.mktemp("few") / "s", problems, trials=1)))


@pytest.fixture(scope="module")
def many(make, tmp_path_factory):
    problems = tuple(f"p{number}" for number in range(MANY_PROBLEMS + 1))
    return Findings(Results(make(tmp_path_factory.mktemp("many") / "s", problems, trials=1)))


def test_up_to_twenty_problems_only_single_ones_are_folded(few):
    assert comparison.section(few).items
    assert not comparison.section(few).sections
    for part in (anytime, datasets):
        section = part.section(few)
        assert section.sections
        assert all(each.folded for each in section.sections)


def test_more_problems_are_folded_one_by_one(many):
    sections = datasets.section(many).sections
    assert len(sections) == MANY_PROBLEMS + 1
    assert all(each.folded for each in sections)


def test_the_matrix_of_many_problems_is_folded_below_its_text(many):
    section = comparison.section(many)
    assert section.text
    assert not section.items
    assert [(each.folded, [item.name for item in each.items]) for each in section.sections] == [(True, ["comparison"])]


def test_the_curves_of_many_problems_are_folded_below_those_of_all(many):
    section = anytime.section(many)
    assert [item.name for item in section.items] == ["targets-reached", "success-rates", "target-sets"]
    (each,) = section.sections  # all are of one dimension
    assert each.folded
    assert each.title == "Each problem"
    assert [item.name for item in each.items] == ["convergence", "expected-running-time"]


def test_problems_of_several_dimensions_are_folded_by_dimension(make, tmp_path):
    findings = Findings(Results(make(tmp_path / "s", tuple(f"p{i}" for i in range(MANY_PROBLEMS + 1)), trials=1)))
    findings.__dict__["dimensions"] = {label: 2 if label == "p3" else 5 for label in findings.problems}
    sections = anytime.section(findings).sections
    assert [each.title for each in sections] == ["Each problem in dimension 5", "Each problem in dimension 2"]
    assert [item.name for item in sections[1].items] == ["convergence-d2", "expected-running-time-d2"]
    assert set(sections[1].items[0].data["problem"]) == {"p3"}


class TestClaim:
    @staticmethod
    def claim(make, folder, optimizers, changes):
        made = make(folder, ("p", "q"), optimizers, changes=changes)
        return verdict.section(Findings(Results(made))).cards[0].text[0]

    def test_nobody_leads_where_all_are_tied(self, make, tmp_path):
        tied = {label: {"fun": 1.0} for label in "abcde"}
        claim = self.claim(make, tmp_path / "s", tuple("abcde"), tied)
        assert claim == "No optimizer leads at 100 evaluations: all have the same mean rank over 2 problems."
