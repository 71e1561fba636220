"""The section on cost: one table, one sentence."""

import pytest

from bench import Results
from bench.topics.cost import section as cost
from bench.topics.cost import words
from bench.topics.findings import Findings


@pytest.fixture
def findings(make, tmp_path):
    return Findings(Results(make(tmp_path / "s", changes={"a": {"calls": 5}, "b": {"calls": 100}})))


def test_the_time_of_an_evaluation_is_split_into_own_and_the_objective_s(findings):
    (table,) = cost.section(findings).items
    trials = findings.trials.whole
    of_a = trials[trials["optimizer"] == "a"]
    own = 1e6 * ((of_a["wall_s"] - of_a["objective_s"]) / of_a["nfev"]).median()
    assert table.frame.at["a", "own µs an evaluation"] == pytest.approx(own)


def test_equal_times_have_neither_a_least_nor_a_most():
    assert words.fastest("a", 0.12, "c", 0.1201) == "A median run takes 120 ms, whatever the optimizer."
