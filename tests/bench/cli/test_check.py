"""``bench check`` of problems: by name, family, pattern or file; an optimizer's check is in test_report.py."""

import pytest

CODE = """
import numpy as np
import bench

class Broken(bench.Problem):
    name, variables, lower, upper = "broken", ("a",), np.zeros(1), np.ones(1)

    def evaluate(self, x):
        return np.full(len(x), np.nan)

fine = bench.FunctionProblem(lambda x: x[:, 0], [0], [1], name="fine", optimum=0, optimum_point=[0])
"""


@pytest.fixture
def files(tmp_path):
    (tmp_path / "own.py").write_text(CODE)
    return tmp_path


def test_a_problem_of_a_file_is_checked_rule_by_rule(bench_here, files):
    done = bench_here("check", "own.py:fine", cwd=files)
    assert done.returncode == 0
    assert "passed: own.py:fine, optimum: 0 is reached at the claimed point" in done.stdout
    assert done.stdout.endswith("fine keeps the contract\n")


def test_a_broken_problem_of_a_file_ends_with_1_and_a_remedy(bench_here, files):
    done = bench_here("check", "own.py:Broken", cwd=files)
    assert done.returncode == 1
    assert "FAILED: own.py:Broken, values: 135 of 135 values are NaN" in done.stdout
    assert "remedy: return one float64 for each point" in done.stdout


@pytest.mark.slow
def test_of_a_pattern_only_what_failed_is_shown_and_the_rest_goes_on(bench_here, tmp_path):
    done = bench_here("check", "star-discrepancy-*-10-d2-i1", cwd=tmp_path)
    assert done.returncode == 1
    assert "passed:" not in done.stdout
    assert "FAILED: star-discrepancy-sobol-10-d2-i1, instances" in done.stdout
    assert "star-discrepancy-halton-10-d2-i1 keeps the contract" in done.stdout
    assert done.stdout.endswith("2 of 3 problems keep the contract\n")
