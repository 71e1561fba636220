"""The objective: counting, the hard budget, the trace, the box, and the streams."""

import numpy as np
import pytest

from bench import BenchError, BudgetExhausted, FunctionProblem, Objective, Trace


def sphere(dimension=3, **options):
    return FunctionProblem(lambda x: (x**2).sum(axis=1), [-5.0] * dimension, [5.0] * dimension, **options)


def objective(problem=None, budget=10, seed=0):
    return Objective(problem or sphere(), budget, np.random.default_rng(seed))


def test_evaluates_batches_and_single_points():
    f = objective()
    assert f([1.0, 2.0, 0.0]) == 5.0
    assert f(np.eye(3)).tolist() == [1.0, 1.0, 1.0]
    assert (f.evaluations, f.remaining) == (4, 6)


def test_never_evaluates_a_row_past_the_budget():
    seen = []
    problem = FunctionProblem(lambda x: seen.append(len(x)) or x[:, 0], [0], [1])
    f = objective(problem, budget=7)
    f(np.full((5, 1), 0.5))
    with pytest.raises(BudgetExhausted):
        f(np.full((5, 1), 0.25))
    with pytest.raises(BudgetExhausted):
        f([0.1])
    assert seen == [5, 2]
    assert f.evaluations == 7
    assert f.best_value == 0.25  # the two rows that the budget still held count


def test_trace_holds_improvements_only_and_in_order():
    f = objective(FunctionProblem(lambda x: x[:, 0], [0], [9]), budget=8)
    f(np.array([[5.0], [7.0], [3.0], [3.0]]))
    f(np.array([[4.0], [2.0], [2.5], [1.0]]))
    assert f.trace.evaluations.tolist() == [1, 3, 6, 8]
    assert f.trace.values.tolist() == [5.0, 3.0, 2.0, 1.0]
    assert f.trace.at([0, 1, 2, 5, 8, 99]).tolist() == [np.inf, 5.0, 5.0, 3.0, 1.0, 1.0]
    assert f.best_point.tolist() == [1.0]


def test_the_best_point_is_a_copy():
    f = objective(FunctionProblem(lambda x: x[:, 0], [0], [9]))
    x = np.array([[5.0]])
    f(x)
    x[:] = 1.0
    assert f.best_point.tolist() == [5.0]


@pytest.mark.parametrize("bad", [5.0001, -5.0001, np.nan, np.inf])
def test_outside_the_box_is_counted_and_worth_nothing(bad):
    f = objective()
    assert f([bad, 0.0, 0.0]) == np.inf
    assert (f.evaluations, f.outside_box) == (1, 1)


def test_nan_counts_as_infinite():
    f = objective(FunctionProblem(lambda x: np.where(x[:, 0] > 0.5, np.nan, x[:, 0]), [0], [1]))
    assert f(np.array([[0.9], [0.2]])).tolist() == [np.inf, 0.2]
    assert f.best_value == 0.2


def test_an_infinite_start_still_leaves_a_point():
    f = objective(FunctionProblem(lambda x: np.full(len(x), np.inf), [0], [1]))
    f(np.array([[0.3], [0.4]]))
    assert f.best_value == np.inf
    assert f.best_point.tolist() == [0.3]


def test_clocks_the_problem_alone(monkeypatch):
    now = 0.0

    def take(seconds):
        nonlocal now
        now += seconds

    def sphere(x):
        take(2.0)
        return (x**2).sum(axis=1)

    class Slow(FunctionProblem):
        def repair(self, x):
            take(8.0)
            return x

    monkeypatch.setattr("bench.objective.perf_counter", lambda: now)
    f = objective(Slow(sphere, [0], [1]))
    f([0.5])
    take(16.0)  # the optimizer's own work
    f(f.initial(3))
    assert f.seconds == 4.0
    assert now == 28.0


def test_initial_points_are_uniform_and_repaired():
    class HalfPlane(FunctionProblem):
        def repair(self, x):
            return np.maximum(np.clip(x, self.lower, self.upper), [[0.0, -5.0]])

    f = objective(HalfPlane(lambda x: x[:, 0], [-5, -5], [5, 5]))
    x = f.initial(4000)
    assert x[:, 0].min() == 0.0
    assert abs((x[:, 0] == 0).mean() - 0.5) < 0.03
    assert abs(x[:, 1].mean()) < 0.2


def test_wrong_shapes_are_refused():
    f = objective()
    with pytest.raises(ValueError, match="shape"):
        f([1.0, 2.0])
    with pytest.raises(ValueError, match="returned shape"):
        objective(FunctionProblem(lambda x: x, [0, 0], [1, 1]))(np.zeros((4, 2)))


def test_a_budget_below_one_is_refused():
    with pytest.raises(BenchError, match="at least 1"):
        objective(budget=0)


def test_bounds_cannot_be_moved():
    with pytest.raises(ValueError, match="read-only"):
        objective().lower[0] = -9


def test_an_empty_trace_has_no_value():
    trace = Trace(np.array([], dtype=np.int64), np.array([]))
    assert trace.at([1, 10]).tolist() == [np.inf, np.inf]
