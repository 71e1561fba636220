"""Runs that end before the budget: at a value that is good enough, or where a function or a callback says so."""

import numpy as np
import pytest

import bench
from bench import BenchError, FunctionProblem, StopRun, solve


def sphere(x):
    return (x**2).sum()


def walk(objective, rng):
    """Evaluate 2.0, 1.9, 1.8, … one at a time; returns once nothing is left."""
    x = 2.0
    while objective.remaining:
        objective([x])
        x -= 0.1


def found(**settings):
    return solve(lambda x: float(x[0]), walk, bounds=[(-2, 2)], budget=30, **settings)


def test_a_run_ends_after_the_call_that_is_good_enough():
    result = found(stop_at=1.55)
    assert (result.nfev, result.stop) == (6, "target")
    assert result.fun == pytest.approx(1.5)
    assert found().stop == "budget"


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"final_target": 1e-8}, "has no known optimum, from which 'final_target' counts; give 'stop_at', a value"),
        ({"final_target": 0}, "'final_target' must be a positive number"),
        ({"stop_at": float("nan")}, "'stop_at' must be a number"),
        ({"journal": True}, "solve has no setting 'journal'"),
        ({"on_evaluatoin": print}, "solve has no setting 'on_evaluatoin'; did you mean 'on_evaluation'?"),
    ],
)
def test_a_goal_that_cannot_be_is_one_sentence(settings, sentence):
    with pytest.raises(BenchError) as caught:
        found(**settings)
    assert sentence in str(caught.value)


def test_an_infeasible_value_is_not_good_enough():
    problem = FunctionProblem(lambda x: x[0], [-2], [2], violations=lambda x: 1 - x[:1], vectorized=False)
    result = solve(problem, walk, budget=30, stop_at=0.5, constraints="penalty")
    assert (result.stop, result.nfev) == ("budget", 30)


def test_evaluations_are_reported_and_may_end_the_run():
    seen = []

    def on_evaluation(count, x, f, best):
        seen.append((count, x.tolist(), f, best))
        if count == 3:
            raise StopRun("enough seen")

    result = found(on_evaluation=on_evaluation)
    assert (result.nfev, result.stop, result.fun) == (3, "enough seen", seen[-1][2])
    assert [(count, f) for count, _, f, _ in seen] == [(1, 2.0), (2, 1.9), (3, pytest.approx(1.8))]
    batch = []
    solve(sphere, "gwo", bounds=[(-5, 5)] * 2, budget=60, on_evaluation=lambda *each: batch.append(each))
    assert [count for count, *_ in batch] == [*range(1, 61)]
    assert [best for *_, best in batch] == np.minimum.accumulate([f for _, _, f, _ in batch]).tolist()


@pytest.mark.parametrize("parallel", [1, 2])
def test_a_function_ends_its_run(parallel):
    def function(x):
        if x[0] < 1.75:
            raise bench.StopRun
        return float(x[0])

    result = solve(function, walk, bounds=[(-2, 2)], budget=30, parallel=parallel)
    assert (result.nfev, result.stop) == (3, "StopRun")
    assert result.fun == pytest.approx(1.8)


def test_a_function_that_ends_its_run_at_once_says_why():
    def function(x):
        raise StopRun("no licence")

    with pytest.raises(RuntimeError, match="without a single evaluation; it was stopped: no licence"):
        solve(bench.FunctionProblem(function, [-2], [2], vectorized=False), walk, budget=30)
