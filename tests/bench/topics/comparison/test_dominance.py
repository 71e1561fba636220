"""The ranking by U-scores; optimizers a, b and c find about 5, 6 and 7 on p and q."""

import pytest

from bench import Results
from bench.topics.comparison import dominance
from bench.topics.findings import Findings


def findings(folder, functions=("p", "q"), **optima):
    """Return findings for which some problems are functions of a suite with such optima."""
    found = Findings(Results(folder))
    found.trials.__dict__.update(suite_functions=list(functions), optima=optima or {"p": 1.0, "q": 1.0})
    return found


def test_the_highest_score_is_ranked_first(make, tmp_path):
    section = dominance.section(findings(make(tmp_path / "s", trials=4)))
    (table,) = section.items
    assert table.frame["rank"].to_dict() == {"a": 1, "b": 2, "c": 3}
    assert table.frame["U-score"].tolist() == [2 * 32, 2 * 16, 0]
    assert table.frame["share %"].tolist() == [100, 50, 0]
    assert table.frame["reached"].tolist() == ["0/8"] * 3
    assert table.bold["U-score"].tolist() == [True, False, False]
    assert len(section.text) == 1


def test_equal_optimizers_share_a_rank(make, tmp_path):
    same = {each: {"fun": 3.0} for each in "abc"}
    (table,) = dominance.section(findings(make(tmp_path / "s", trials=2, changes=same), p=1.0, q=1.0)).items
    assert table.frame["rank"].tolist() == [1, 1, 1]
    assert table.frame["share %"].tolist() == [50, 50, 50]


def test_failed_trials_lose(make, tmp_path):
    (table,) = dominance.section(findings(make(tmp_path / "s", trials=4, fail=[("p", "a"), ("q", "a")]))).items
    assert table.frame["rank"].to_dict() == {"b": 1, "c": 2, "a": 3}


def test_a_problem_with_trials_missing_is_left_out_and_said(make, tmp_path):
    section = dominance.section(findings(make(tmp_path / "s", trials=4, skip=[("p", "b", 3)])))
    assert "1 problem of 2 is left out: the optimum is unknown or beaten, or" in section.text[1]
    assert section.items[0].data["problem"].unique().tolist() == ["q"]


@pytest.mark.parametrize("optima", [{"p": 6.5, "q": 6.5}, {"r": 1.0}])
def test_without_a_problem_to_score_there_is_a_sentence_and_no_table(make, tmp_path, optima):
    found = findings(make(tmp_path / "s", trials=2), **optima)
    section = dominance.section(found)
    assert "2 problems of 2 are left out" in section.text[1]
    assert section.items == ()


def test_there_is_no_ranking_of_one_optimizer_or_without_a_suite(make, tmp_path):
    one = findings(make(tmp_path / "one", optimizers=("a",), trials=2))
    assert dominance.section(one) is None
    assert dominance.section(findings(make(tmp_path / "s", trials=2), functions=())) is None
