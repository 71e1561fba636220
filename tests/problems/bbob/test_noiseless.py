"""The families bbob, bbob-boxed and bbob-largescale against COCO's own package."""

import os

import numpy as np
import pytest

from bench import load_problem
from tests.problems.bbob.best import function_of, name

CASES = [
    *(("bbob", function, 5, instance) for function in range(1, 25) for instance in (1, 15)),
    *(("bbob-boxed", function, 3, 2) for function in range(1, 25)),
    *(("bbob-largescale", function, 20, 3) for function in range(1, 25)),
    ("bbob", 8, 2, 1000), ("bbob", 8, 40, 71), ("bbob-boxed", 24, 40, 4),
]  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_values_are_those_of_coco_bit_for_bit(case):
    problem, theirs = load_problem(name(*case)), function_of(*case)
    assert theirs.id_triple == case[1:]
    np.testing.assert_array_equal(problem.lower, theirs.lower_bounds)
    np.testing.assert_array_equal(problem.upper, theirs.upper_bounds)
    x = np.random.default_rng(1).uniform(-6, 6, (20, problem.dimension))  # some outside the box
    np.testing.assert_array_equal(problem.evaluate(x), [theirs(row) for row in x])


@pytest.mark.parametrize("case", CASES)
def test_the_optimum_is_the_value_of_coco_s_best_point(case, best):
    problem = load_problem(name(*case))
    value = problem.evaluate(best[case][None])[0]
    assert problem.optimum <= value <= problem.optimum + 1e-8


def test_a_loaded_problem_works_in_a_forked_process():
    problem = load_problem("bbob-f16-d5-i1")
    x = np.full((3, 5), 0.5)
    before = problem.evaluate(x).tobytes()
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.write(writer, problem.evaluate(x).tobytes())
        os._exit(0)
    os.waitpid(child, 0)
    assert os.read(reader, 100) == before
