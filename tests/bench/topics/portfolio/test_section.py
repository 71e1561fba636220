"""The section on which optimizers to take."""

import pandas as pd
import pytest

from bench import Results
from bench.analysis.portfolio import portfolio_of
from bench.topics.findings import Findings
from bench.topics.portfolio import section as portfolio
from bench.topics.portfolio.choice import points
from bench.topics.portfolio.figures import portfolio_figure

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
    figure, table = section.items
    assert figure.data["optimizers"].tolist() == ["a", "b", "c"]
    assert table.frame["taken for, %"].to_dict() == pytest.approx({"a": 100, "b": 0, "c": 0})


def test_few_optimizers_problems_or_trials_have_no_section(sections):
    assert sections(optimizers=("a", "b")) is None
    assert sections(problems=PROBLEMS[:3]) is None
    assert sections(trials=1) is None
    assert sections(fail=[(problem, optimizer) for problem in PROBLEMS for optimizer in "abc"]) is None


def test_failed_trials_reach_nothing_and_missing_ones_leave_the_problem_out(sections):
    section = sections(fail=[(problem, "a") for problem in PROBLEMS])
    assert "b on all trials" in section.text[1]
    assert section.items[1].data.set_index("optimizer")["score"]["a"] == 0
    assert "Left out: 1 problem" in sections(skip=[("q", "b")]).text[4]


def test_sets_of_many_optimizers_are_not_all_compared_and_the_section_says_so(sections):
    section = sections(optimizers=tuple(f"o{number}" for number in range(14)), trials=2)
    assert "one after the other, so a smaller set may exist" in section.text[2]


def test_the_picture_has_each_optimizer_and_the_sets_that_gain():
    found = portfolio_of(
        pd.DataFrame(
            [
                (p, o, trial, float(p.startswith(o)))
                for p in ("a1", "a2", "b1", "b2")
                for o in "abc"
                for trial in (0, 1)
            ],
            columns=["problem", "optimizer", "trial", "score"],
        ),
        {},
    )
    figure = portfolio_figure(found)
    assert figure.data.values.tolist() == [["a", 1, 0.5], ["b", 1, 0.5], ["c", 1, 0.0], ["a + b", 2, 1.0]]
    assert figure.caption.endswith(
        "best set found of each size up to the first within 5% of the virtual best. Line: the virtual best, 100.0%."
    )
    (ax,) = figure.figure.axes
    assert [bar.get_width() for bar in ax.patches] == figure.data["score"].tolist()
    assert [label.get_text() for label in ax.get_yticklabels()] == ["a", "b", "c", "best set of 2"]


def test_of_many_optimizers_the_best_are_drawn(sections):
    figure = sections(optimizers=tuple(f"o{number:02}" for number in range(45)), trials=2).items[0]
    assert len(figure.data) == 45
    assert "each of the 40 best of 45 optimizers" in figure.caption


def test_a_difference_that_rounds_to_nothing_has_no_sign():
    assert points(-0.0001, -0.0004, 0.01) == "0.0 (95% interval 0.0 to 1.0)"
    assert points(-0.0001, float("nan"), float("nan")) == "0.0 (no interval, as this is one function)"
