"""The section on time: machines are named, and the cores of all of them count."""

import pytest

from bench import Results
from bench.topics.findings import Findings
from bench.topics.time import section as time
from tests.bench.topics.time.records import NEWER, RECORD


def test_machines_are_named(render):
    assert "on the machine named below (Xeon)." in render([RECORD, NEWER], of=time).text
    assert "on the machine named below." in render([{"processor": None}], of=time).text
    text = render([RECORD, RECORD | {"processor": "EPYC"}], of=time).text
    assert "on the machines named below (Xeon and EPYC)." in text


@pytest.mark.parametrize(
    ("records", "sentence"),
    [
        ([{"jobs": 2, "cores": 2}, {"jobs": 1, "cores": 2}], "No more trials"),
        ([{"jobs": 2, "cores": 2}, {"jobs": 3, "cores": 2}], "More trials"),
        ([{"jobs": 4, "cores": 2, "host": "one"}, {"jobs": 4, "cores": 2, "host": "two"}], "No more trials"),
        ([{"jobs": 4, "cores": 2, "host": "one"}, {"jobs": 4, "cores": 2, "host": "one"}], "More trials"),
    ],
)
def test_the_cores_of_all_machines_of_a_run_count(render, records, sentence):
    starts = ["a", "b"] if "host" not in records[0] else ["a", "a"]
    records = [{"started": start} | record for start, record in zip(starts, records, strict=True)]
    assert f" {sentence} ran at a time than there were cores" in render(records, of=time).text


def test_what_is_not_noted_is_not_judged(render):
    assert "than there were cores" not in render([{"jobs": 2}], of=time).text


def test_evaluations_a_call_are_shown_where_they_are_known(make, tmp_path, render):
    calls = {"a": {"calls": 5}, "b": {"calls": 100}}
    (_, table), *_ = [time.section(Findings(Results(make(tmp_path / "s", changes=calls)))).items]
    assert table.frame["evals/call"].tolist()[:2] == [20.0, 1.0]
    assert "evaluations a call of the objective show how many" in table.caption
    without = render([RECORD], of=time).tables["timing"]
    assert "evals/call" not in without.frame
    assert "a call" not in without.caption
