"""The objective: counting, the hard budget, the trace, the box, the streams, and one private copy of the points."""

import subprocess
import sys
import threading
from contextlib import contextmanager
from functools import partial
from itertools import pairwise
from random import Random
from textwrap import dedent

import numpy as np
import pytest

import bench
from bench import BenchError, BudgetExhausted, Objective, Trace
from tests.bench.objectives import objective

FunctionProblem = partial(bench.FunctionProblem, vectorized=True)  # whose calls are counted

pytestmark = pytest.mark.usefixtures("scanner")  # compiled and interpreted


def test_evaluates_batches_and_single_points():
    f = objective()
    assert f([1.0, 2.0, 0.0]) == 5.0
    assert f(np.eye(3)).tolist() == [1.0, 1.0, 1.0]
    assert (f.nfev, f.calls, f.remaining) == (4, 2, 6)


def test_calls_that_evaluate_nothing_do_not_count():
    f = objective(budget=5)
    f(np.empty((0, 3)))
    f(np.zeros((5, 3)))
    with pytest.raises(BudgetExhausted):
        f(np.zeros((2, 3)))
    assert (f.calls, f.nfev) == (1, 5)


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
    assert f.nfev == 7
    assert f.fun == 0.25  # the two rows that the budget still held count


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
    assert (f.nfev, f.outside_box) == (1, 1)


def test_nan_counts_as_infinite():
    f = objective(FunctionProblem(lambda x: np.where(x[:, 0] > 0.5, np.nan, x[:, 0]), [0], [1]))
    assert f(np.array([[0.9], [0.2]])).tolist() == [np.inf, 0.2]
    assert f.fun == 0.2


def test_an_infinite_start_still_leaves_a_point():
    f = objective(FunctionProblem(lambda x: np.full(len(x), np.inf), [0], [1]))
    f(np.array([[0.3], [0.4]]))
    assert f.fun == np.inf
    assert f.best_point.tolist() == [0.3]


def test_clocks_the_problem_alone(monkeypatch):
    now = 0.0

    def take(seconds):
        nonlocal now
        now += seconds

    def sphere(x):
        take(2.0)
        return (x**2).sum(axis=1)

    class Slow(bench.FunctionProblem):
        def repair(self, x):
            take(8.0)
            return x

    monkeypatch.setattr("bench.objective.perf_counter", lambda: now)
    f = objective(Slow(sphere, [0], [1], vectorized=True))
    f([0.5])
    take(16.0)  # the optimizer's own work
    f(f.initial(3))
    assert f.objective_s == 4.0
    assert now == 28.0


def test_initial_points_are_uniform_and_repaired():
    class HalfPlane(bench.FunctionProblem):
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


@contextmanager
def threads_switch_all_the_time():
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        yield
    finally:
        sys.setswitchinterval(interval)


# --- one private copy ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(2,), (1, 2), (3, 2)])
def test_points_that_change_during_the_call_win_nothing(shape):
    x = np.full(shape, 2.0)

    def meanwhile(given):
        values = given.sum(axis=1)
        x[:] = 99.0  # another thread of the optimizer
        return values

    f = objective(FunctionProblem(meanwhile, [-5, -5], [5, 5]))
    assert np.all(f(x) == 4.0)
    assert (f.fun, f.best_point.tolist(), f.outside_box) == (4.0, [2.0, 2.0], 0)


def test_a_thread_that_moves_a_point_all_the_time_wins_nothing():
    x, given = np.full(3, 1.0), []
    stopped = threading.Event()

    def move():
        while not stopped.is_set():
            x[:] = 1.0
            x[:] = 9.0  # outside
            x[0] = 0.0  # outside, and a sum that is lower than any within

    def total(points):
        given.append(points.copy())
        return points.sum(axis=1)

    problem = FunctionProblem(total, [1.0] * 3, [5.0] * 3)
    f = objective(problem, budget=4000)
    with threads_switch_all_the_time():
        mover = threading.Thread(target=move)
        mover.start()
        worth = [f(x) if turn % 2 else f(x[np.newaxis])[0] for turn in range(4000)]
        stopped.set()
        mover.join()
    inside = [bool(((each >= 1.0) & (each <= 5.0)).all()) for each in given]
    assert worth == [each.sum() if ok else np.inf for each, ok in zip(given, inside, strict=True)]
    assert f.outside_box == inside.count(False)
    assert f.best_point.tolist() in [[1.0] * 3] or not any(inside)


@pytest.mark.parametrize("shape", [(2,), (1, 2)])
def test_numbers_that_change_from_reading_to_reading_are_read_once(shape):
    class Shifty:
        reads = 0

        def __float__(self):
            Shifty.reads += 1
            return [1.0, 3.0, 99.0, -99.0][Shifty.reads - 1]

    class Array:
        reads = 0

        def __array__(self, dtype=None, copy=None):
            Array.reads += 1
            return np.full(shape, 4.0 if Array.reads == 1 else -99.0)

    f = objective(FunctionProblem(lambda x: x.sum(axis=1), [-5, -5], [5, 5]))
    x = np.array([Shifty(), Shifty()], dtype=object).reshape(shape)
    assert (np.ravel(f(x)).tolist(), f.best_point.tolist(), Shifty.reads) == ([4.0], [1.0, 3.0], 2)
    assert (np.ravel(f(Array())).tolist(), f.best_point.tolist(), Array.reads) == ([8.0], [1.0, 3.0], 1)


@pytest.mark.parametrize("shape", [(2,), (1, 2), (3, 2)])
def test_a_problem_that_writes_into_its_argument_moves_nothing(shape):
    def writes(x):
        values = x.sum(axis=1)
        x[:] = -99.0
        return values

    f, x = objective(FunctionProblem(writes, [-5, -5], [5, 5])), np.full(shape, 2.0)
    assert np.all(f(x) == 4.0)
    assert np.all(x == 2.0)
    assert (f.best_point.tolist(), f.outside_box) == ([2.0, 2.0], 0)


@pytest.mark.parametrize("shape", [(1,), (1, 1), (2, 1)])
def test_a_problem_may_keep_its_arguments(shape):
    kept = []
    f = objective(FunctionProblem(lambda x: kept.append(x) or x[:, 0], [0], [9]))
    values = [f(np.full(shape, value)) for value in (3.0, 2.0, 4.0)]
    assert [each[0, 0] for each in kept] == [3.0, 2.0, 4.0]
    assert [np.ravel(each)[0] for each in values] == [3.0, 2.0, 4.0]


def test_values_are_the_optimizers_own():
    table = np.array([2.0, 1.0])
    f = objective(FunctionProblem(lambda x: table, [0], [9]))
    f(np.ones((2, 1)))[:] = 7.0
    assert table.tolist() == [2.0, 1.0]


# --- threads, failures and interruptions ---------------------------------------------------------------------------


def test_threads_do_not_exceed_the_budget_together():
    budget, seen, refusals = 3000, [], []

    def noted(x):
        seen.extend(x[:, 0].tolist())
        return x[:, 0]

    f = Objective(FunctionProblem(noted, [0], [1]), budget, np.random.default_rng(0), refusals.append)

    def ask(seed):
        draw = Random(seed).random
        while True:
            try:
                f(np.array([draw()]))
                f(np.array([[draw()], [draw()], [draw()]]))
                f([draw()])
            except BudgetExhausted:
                return

    with threads_switch_all_the_time():
        threads = [threading.Thread(target=ask, args=(seed,)) for seed in range(8)]
        for each in threads:
            each.start()
        for each in threads:
            each.join()
    assert f.nfev == len(seen) == budget
    assert len(refusals) == 8
    best = np.minimum.accumulate(seen)
    assert f.trace.at(np.arange(1, budget + 1)).tolist() == best.tolist()
    assert f.best_point.tolist() == [f.fun] == [best[-1]]


@pytest.mark.parametrize("point", [[0.5], [9.0]], ids=["inside", "outside"])
@pytest.mark.parametrize("single", [True, False])
def test_minus_infinity_is_refused_and_not_counted(point, single):
    f = objective(FunctionProblem(lambda x: np.full(len(x), -np.inf), [0], [1]))
    with pytest.raises(ValueError, match="returned -inf"):
        f(np.array(point) if single else np.array([point, point]))
    assert (f.nfev, f.outside_box, f.best_point, f.fun) == (0, 0, None, np.inf)
    assert not len(f.trace.values)


@pytest.mark.parametrize("x", [np.array([0.5]), np.array([[0.5], [0.6]]), [0.5]], ids=["point", "batch", "list"])
def test_a_failed_evaluation_is_not_counted_and_the_next_one_works(x):
    fails = True

    def sometimes(x):
        if fails:
            raise ZeroDivisionError
        return x[:, 0]

    f = objective(FunctionProblem(sometimes, [0], [1]))
    with pytest.raises(ZeroDivisionError):
        f(x)
    fails = False
    f(x)
    assert (f.nfev, f.fun) == (np.size(x), 0.5)


class InterruptedAtError(BaseException):
    """What a signal's handler may raise."""


def interrupted_at(moment, call):
    """Whether a call is interrupted at the ``moment``-th of those in it at which a signal may strike.

    These are the start of a function in Python and the return of another one: there Python looks for signals.
    """
    left = moment

    def strike(frame, event, argument):
        nonlocal left
        left -= event in ("call", "c_return")
        if not left:
            raise InterruptedAtError

    sys.setprofile(strike)
    try:
        call()
    except InterruptedAtError:
        return True
    finally:
        sys.setprofile(None)
    return False


@pytest.mark.parametrize("x", [np.full(3, 0.5), np.full((2, 3), 0.5)], ids=["point", "batch"])
def test_an_interruption_at_any_moment_leaves_the_objective_usable(x):
    f, moment = objective(budget=10**9), 1
    while interrupted_at(moment, lambda: f(x)):
        assert not f._lock.locked(), moment  # a further call would wait for ever
        moment += 1
    assert moment > 5
    assert np.all(f(x) == 0.75)


# --- when numba is loaded ------------------------------------------------------------------------------------------


@pytest.mark.sampled(1)
def test_numba_is_loaded_only_where_the_budget_is_worth_it():
    code = """if True:
        import sys
        import bench, numpy as np
        from bench.objective import Objective, scanner
        problem = bench.FunctionProblem(lambda x: (x**2).sum(axis=1), [-5.0] * 10, [5.0] * 10)
        small = Objective(problem, 999, np.random.default_rng(0))
        assert small(np.ones(10)) == 10.0 and "numba" not in sys.modules
        large = Objective(problem, 1000, np.random.default_rng(0))
        assert large(np.ones(10)) == 10.0 and "numba" in sys.modules
        assert scanner(1, 1) is scanner(10**9, 1)
        """
    subprocess.run([sys.executable, "-c", code], check=True)


def test_after_its_limit_of_time_no_call_is_begun_and_the_one_under_way_is_finished():
    f = objective(seconds=1e-9)
    f(np.zeros((7, 3)))
    with pytest.raises(BudgetExhausted):
        f(np.zeros(3))
    assert (f.nfev, f.stop_reason) == (7, "time")


def test_no_optimizer_declares_the_limit_of_time():
    f = objective()
    f.stop("time")
    assert f.stop_reason == "time (declared)"


def test_what_an_optimizer_logs_is_kept_by_evaluations_and_costs_none():
    f = objective()
    f.log(step=1)
    f(np.zeros((4, 3)))
    f.log(step=0.5, spread=float("nan"))
    assert f.logged == {"step": [(0, 1.0), (4, 0.5)], "spread": [(4, None)]}
    assert f.nfev == 4


def test_a_log_is_thinned_evenly_and_keeps_the_first_value():
    f = objective(budget=1000)
    for step in range(1000):
        f(np.zeros(3))
        f.log(step=step)
    kept = f.logged["step"]
    assert kept[0] == (1, 0.0)
    assert {other[0] - one[0] for one, other in pairwise(kept)} == {8}
    assert 100 <= len(kept) < 200


def test_of_one_evaluation_the_last_value_is_kept():
    f = objective()
    f.log(step=1.0)
    f.log(step=2.0)
    assert f.logged == {"step": [(0, 2.0)]}


def test_too_many_names_and_no_numbers_are_refused():
    f = objective()
    with pytest.raises(ValueError, match="an optimizer may log 20 names, and 'x20' is one more"):
        f.log(**{f"x{number}": 1.0 for number in range(21)})
    with pytest.raises(TypeError):
        f.log(x0=[1.0])


@pytest.mark.parametrize("seed", range(20))
def test_large_batches_are_scanned_by_numpy_to_the_same_end(seed):
    from bench.objective import _scan, _scan_batch

    rng = np.random.default_rng(seed)
    points, box = rng.uniform(-1.1, 1.1, (40, 3)), np.array([[-1.0] * 3, [1.0] * 3])
    values = rng.choice([1.0, np.nan, np.inf, 0.5] + [-np.inf] * (seed % 5 == 0), 40)
    points[3, 1], other = np.nan, values.copy()
    found = _scan(points, values, box)
    assert _scan_batch(points, other, box) == found
    if found[0] != -np.inf:
        np.testing.assert_array_equal(values, other)


def test_numba_is_loaded_by_the_first_call_with_few_points_that_is_worth_it():
    code = """
        import sys
        import numpy as np
        from bench import FunctionProblem, Objective
        problem = FunctionProblem(lambda x: x.sum(axis=1), [-1, -1], [1, 1], vectorized=True)
        for points, loaded in ((50, False), (1, True)):
            objective = Objective(problem, 10**6, np.random.default_rng(0))
            objective(objective.initial(points))
            assert ("numba" in sys.modules) == loaded, points
    """
    subprocess.run([sys.executable, "-c", dedent(code)], check=True)
