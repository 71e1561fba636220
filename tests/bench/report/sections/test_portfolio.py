"""The section on which optimizers to take."""

import pytest

from bench import Results
from bench.report.findings import Findings
from bench.report.sections import portfolio

PROBLEMS = ("p", "q", "r", "s")


@pytest.fixture(scope="module")
def sections(make, tmp_path_factory):
    """Return a function that makes the section of a study."""

    def of(**changes):
        folder = make(tmp_path_factory.mktemp("portfolio") / "s", **{"problems": PROBLEMS} | changes)
        return portfolio.section(Findings(Results(folder)))

    return of


def test_one_that_is_best_on_all_problems_is_enough(sections):
    section = sections()
    assert "These data show no gap between the virtual best and the single best" in section.text[1]
    assert "a on all trials" in section.text[1]
    assert "has 1 optimizer, a, with" in section.text[2]
    assert "all sets of its size and smaller ones were compared" in section.text[2]
    assert "here 0 can be described" in section.text[3]
    (table,) = section.items
    assert table.frame["taken for, %"].to_dict() == pytest.approx({"a": 100, "b": 0, "c": 0})


def test_few_optimizers_problems_or_trials_have_no_section(sections):
    assert sections(optimizers=("a", "b")) is None
    assert sections(problems=PROBLEMS[:3]) is None
    assert sections(trials=1) is None
    assert sections(fail=[(problem, optimizer) for problem in PROBLEMS for optimizer in "abc"]) is None


def test_failed_trials_reach_nothing_and_missing_ones_leave_the_problem_out(sections):
    section = sections(fail=[(problem, "a") for problem in PROBLEMS])
    assert "b on all trials" in section.text[1]
    assert section.items[0].data.set_index("optimizer")["score"]["a"] == 0
    assert "Left out: 1 problem" in sections(skip=[("q", "b")]).text[4]


def test_equal_trials_are_ties(sections):
    section = sections(changes={each: {"fun": 5.0} for each in "abc"})
    assert "no gap" in section.text[1] or "0.0" in section.text[1]


def test_sets_of_many_optimizers_are_not_all_compared_and_the_section_says_so(sections):
    section = sections(optimizers=tuple(f"o{number}" for number in range(14)), trials=2)
    assert "one after the other, so a smaller set may exist" in section.text[2]
