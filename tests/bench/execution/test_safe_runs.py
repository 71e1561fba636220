"""Single runs in processes that can be lost: their records, and one sentence on each that fails."""

import os

import numpy as np
import pytest

from bench import BenchError, FunctionProblem, Optimizer, load_optimizer
from bench.execution.safe_runs import found, recorded, safe_call, safe_run
from bench.sandbox.callers import Callers

RECORD = {"number": 5, "text": "a", "points": np.full((2, 1), np.pi), "worst": np.inf}


def bowl(x):
    return (x**2).sum(axis=1)


def test_numbers_texts_and_arrays_arrive_with_every_digit():
    with Callers(1, os.getpid) as callers:
        there = found(callers.answer(safe_call("a", dict, RECORD))[1], dict)
    assert there == RECORD | {"points": [[np.pi], [np.pi]]}


def test_a_lost_process_costs_no_other_group_anything():
    with Callers(1, os.getpid) as callers:
        calls = safe_call("a", os._exit, 3), safe_call("b", dict, RECORD)
        (_, lost), (_, kept) = callers.answers(calls)
    with pytest.raises(BenchError, match=r"^the optimizer ended its process \(exit code 3\)$"):
        found(lost, dict)
    assert found(kept, lambda record: record["number"]) == 5


@pytest.mark.parametrize("answer", [None, 5, [], "x", {}, {"x": [1]}])
def test_what_is_no_record_is_refused(answer):
    with pytest.raises(BenchError, match="gave an answer that is no record of a run"):
        found(answer, lambda each: each["x"].shape)


class Raising(Optimizer):
    """Raises what no handler of exceptions catches."""

    def minimize(self, objective, rng):
        raise SystemExit("boom")


@pytest.mark.parametrize("name", ["the optimizer", "mine"])
def test_an_optimizer_that_raises_is_named_in_one_sentence(name):
    problem = FunctionProblem(bowl, [-1.0], [1.0], name="bowl", vectorized=True)
    with pytest.raises(BenchError, match=f"^{name} failed on bowl: SystemExit: boom$"):
        safe_run(problem, Raising(), budget=9, seed=0, name=name)


def test_a_problem_that_raises_is_blamed_itself():
    def divide(x):
        return 1 / 0

    problem = FunctionProblem(divide, [-1.0], [1.0], name="hole")
    with pytest.raises(BenchError, match=r"^hole failed: ProblemError: ZeroDivisionError: division by zero$"):
        safe_run(problem, load_optimizer("random-search"), budget=9, seed=0)


def test_what_a_function_raises_beside_its_run_is_a_sentence_too():
    def construct():
        raise RuntimeError("no licence")

    assert recorded(construct) == {"error": "the optimizer failed: RuntimeError: no licence"}
