"""What the tests would miss, and from how many trials on they find complete separation."""

import re

import pytest

from bench import Results
from bench.topics.findings import Findings
from bench.topics.trials import power
from bench.topics.trials.design import foreseen


@pytest.mark.parametrize(
    ("problems", "optimizers", "enough", "tests"),
    [(("p",), ("a", "b"), 6, "the test"), (("p", "q"), ("a", "b"), 9, "the 2 tests"),
     (("p",), ("a", "b", "c"), 8, "the 3 tests")],
)  # fmt: skip
def test_the_trials_that_are_enough_are_those_of_the_rule(make, tmp_path, problems, optimizers, enough, tests):
    few, more = (
        Findings(Results(make(tmp_path / str(trials), problems, optimizers, trials=trials)))
        for trials in (enough - 1, enough)
    )
    said = f"nothing is found on single problems; from {enough} trials a cell on {tests} would find complete separation"
    assert said in power.blindness(few)
    assert set(few.final.pairs["lower"]) == {""}
    assert list(more.final.pairs["lower"]) == list(more.final.pairs["first"])  # each optimizer is 1 below the next
    assert "would often miss" in power.blindness(more)


def test_a_report_has_the_power_that_was_foreseen(make, tmp_path):
    findings = Findings(Results(make(tmp_path / "s", trials=15)))
    as_it_is = foreseen(findings.study)[1]
    found = re.findall(r"(?:problem|problems) (\d\.\d+)", as_it_is)
    assert re.findall(r"A12 below (\d\.\d+)", power.blindness(findings)) == found
    assert len(found) == 2
