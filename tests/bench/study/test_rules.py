"""The rules of a study's trials."""

import numpy as np
import pytest

from bench import BenchError, FunctionProblem, Study
from bench.study.rules import Rules


def test_the_difference_to_the_optimum_is_that_of_reports():
    for optimum in (79.48, -0.1, 0.0, 1e6 + 0.3):
        problem = FunctionProblem(np.sum, [0], [1], optimum=optimum)
        value = Rules(final_target=1e-8).goal(problem)
        assert value - optimum <= 1e-8 < np.nextafter(value, np.inf) - optimum
    assert Rules(final_target=1e-8, stop_at=1e9).goal(problem) == 1e9
    assert Rules().goal(problem) == -np.inf


def test_rules_of_a_study_are_no_table():
    with pytest.raises(BenchError, match="'rules' must be a bench"):
        Study("s", (), (), rules={"parallel": 2})
