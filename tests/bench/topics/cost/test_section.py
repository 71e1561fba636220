"""The section on cost: one table, one sentence."""

import pytest

from bench import Results
from bench.topics.cost import section as cost
from bench.topics.findings import Findings


@pytest.fixture
def findings(make, tmp_path):
    return Findings(Results(make(tmp_path / "s", changes={"a": {"calls": 5}, "b": {"calls": 100}})))


def test_one_sentence_names_the_least_and_the_most_time(findings):
    (text,) = cost.section(findings).text
    assert text.startswith("A run of ")
    assert len(text.split()) <= 30


def test_evaluations_a_call_are_shown_where_they_are_known(findings, make, tmp_path):
    (table,) = cost.section(findings).items
    assert sorted(table.frame["a call"].dropna())[:2] == [1.0, 20.0]
    (other,) = cost.section(Findings(Results(make(tmp_path / "t")))).items
    assert "a call" not in other.frame


def test_the_time_of_an_evaluation_is_split_into_own_and_the_objective_s(findings):
    (table,) = cost.section(findings).items
    trials = findings.trials.whole
    of_a = trials[trials["optimizer"] == "a"]
    own = 1e6 * ((of_a["wall_s"] - of_a["objective_s"]) / of_a["nfev"]).median()
    assert table.frame.at["a", "own µs an evaluation"] == pytest.approx(own)
