"""Sections of a study of many problems, or of many optimizers: what is said of all first, single ones folded away."""

import pytest

from bench import Results
from bench.report.page import grid
from bench.topics.anytime import section as anytime
from bench.topics.comparison import section as comparison
from bench.topics.datasets import section as datasets
from bench.topics.findings import COLOURED, MANY_OPTIMIZERS, MANY_PROBLEMS, Findings


@pytest.fixture(scope="module")
def many(make, tmp_path_factory):
    problems = tuple(f"p{number}" for number in range(MANY_PROBLEMS + 1))
    return Findings(Results(make(tmp_path_factory.mktemp("many") / "s", problems, trials=1)))


@pytest.mark.slow
def test_more_problems_are_folded_one_by_one(many):
    sections = datasets.section(many).sections
    assert len(sections) == MANY_PROBLEMS + 1
    assert all(each.folded for each in sections)


def test_the_matrix_of_many_problems_is_folded_below_its_text(many):
    section = comparison.section(many)
    assert section.text
    assert not section.items
    assert [(each.folded, [item.name for item in each.items]) for each in section.sections] == [(True, ["comparison"])]


@pytest.mark.slow
def test_the_curves_of_many_problems_are_folded_below_those_of_all(many):
    section = anytime.section(many)
    assert [item.name for item in section.items] == [
        "ranks-over-budget", "targets-reached", "success-rates", "target-sets",
    ]  # fmt: skip
    (each,) = section.sections
    assert each.folded
    assert each.title == "Each problem"
    assert [item.name for item in each.items] == ["convergence", "expected-running-time"]


@pytest.mark.slow
def test_problems_of_several_dimensions_are_folded_by_dimension(make, tmp_path):
    findings = Findings(Results(make(tmp_path / "s", tuple(f"p{i}" for i in range(MANY_PROBLEMS + 1)), trials=1)))
    findings.trials.__dict__["dimensions"] = {label: 2 if label == "p3" else 5 for label in findings.trials.problems}
    sections = anytime.section(findings).sections
    assert [each.title for each in sections] == ["Each problem in dimension 5", "Each problem in dimension 2"]
    assert [item.name for item in sections[1].items] == ["convergence-d2", "expected-running-time-d2"]
    assert set(sections[1].items[0].data["problem"]) == {"p3"}


@pytest.fixture(scope="module")
def wide(make, tmp_path_factory):
    labels = tuple(f"o{number:02d}" for number in range(MANY_OPTIMIZERS + 2, 0, -1))  # the last one is the worst
    return Findings(Results(make(tmp_path_factory.mktemp("wide") / "s", ("p", "q", "r"), labels, trials=5)))


class TestManyOptimizers:
    def test_only_the_best_have_a_colour(self, wide):
        own = [label for label, pen in wide.display.pens.items() if not pen.background]
        assert own == wide.final.ranked[:COLOURED]

    def test_a_problem_shows_the_pairs_of_its_first_optimizer(self, wide):
        tests = next(item for item in datasets.section(wide).sections[0].items if item.name == "tests-p")
        assert len(tests.frame) == MANY_OPTIMIZERS + 1
        assert all(wide.final.ranked[0] in pair for pair in tests.frame.index)
        assert len(tests.data) == (MANY_OPTIMIZERS + 2) * (MANY_OPTIMIZERS + 1) / 2


@pytest.fixture(scope="module")
def crowd(make, tmp_path_factory):
    labels = ("e", "d", "c", "b", "a")  # the last one is the worst
    with pytest.MonkeyPatch.context() as patch:
        for name, value in (("CROWD", 4), ("MANY_OPTIMIZERS", 3), ("COLOURED", 2)):
            patch.setattr(f"bench.topics.findings.display.{name}", value)
        patch.setattr(datasets, "MANY_OPTIMIZERS", 3)
        patch.setattr(datasets, "SHOWN", 3)
        findings = Findings(Results(make(tmp_path_factory.mktemp("crowd") / "out", ("p",), labels)))
        sections = [anytime.section(findings), datasets.section(findings).sections[0]]
        return findings, {item.name: item for each in (sections[0].sections[0], sections[1]) for item in each.items}


class TestACrowd:
    def test_curves_of_a_problem_are_those_of_the_best(self, crowd):
        _, items = crowd
        assert set(items["convergence"].data["optimizer"]) == {"e", "d"}

    def test_tables_of_a_problem_show_the_best_and_write_all(self, crowd):
        _, items = crowd
        cells = items["cells-p"]
        assert [row[0].text for row in grid(cells).rows] == ["e", "d", "c"]
        assert sorted(cells.data["optimizer"]) == ["a", "b", "c", "d", "e"]
        assert len(grid(items["tests-p"]).rows) == 3

    def test_pairs_are_written_among_the_best(self, crowd):
        findings, _ = crowd
        assert len(findings.final.pairs) == 10
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("bench.topics.findings.display.CROWD", 4)
            written = findings.display.written_pairs
        assert set(written["first"]) | set(written["second"]) == {"e", "d", "c", "b"}
        assert len(written) == 6
