"""What a report ranks and tests can be had as a frame."""

import pandas as pd

from bench import Results
from bench.analysis.cells import labels
from bench.topics.findings import Findings
from tests.bench.formats.made import make


def test_it_is_the_frame_that_a_report_tests(filled):
    results = Results(filled.path)
    pd.testing.assert_frame_equal(results.pooled(), Findings(results).trials.frame, check_exact=True)


def test_instances_of_a_function_are_one_problem(tmp_path):
    problems = {"classical-sphere-d2-i1": 2, "classical-sphere-d2-i2": 2, "sphere-2": 2}
    pooled = make(tmp_path / "s", problems).pooled()
    assert labels(pooled, "problem") == ["classical-sphere-d2", "sphere-2"]
    assert {*pooled["instance"].dropna()} == {1, 2}
