"""The objective: counting, the hard budget, the trace, the box, the streams, and one private copy of the points."""

import subprocess
import sys
import threading
from contextlib import contextmanager
from functools import partial
from itertools import pairwise
from random import Random

import numpy as np
import pytest

import bench
from bench import BenchError, BudgetExhausted
from tests.bench.objectives import objective

FunctionProblem = partial(bench.FunctionProblem, vectorized=True)  # whose calls are counted

pytestmark = pytest.mark.usefixtures("scanner")  # compiled and interpreted


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


def test_a_budget_below_one_is_refused():
    with pytest.raises(BenchError, match="at least 1"):
        objective(budget=0)


def test_bounds_cannot_be_moved():
    with pytest.raises(ValueError, match="read-only"):
        objective().lower[0] = -9


@contextmanager
def threads_switch_all_the_time():
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        yield
    finally:
        sys.setswitchinterval(interval)


# --- one private copy ---------------------------------------------------------------------------------------------


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

    f = objective(FunctionProblem(noted, [0], [1]), budget, 0, refusals.append)

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


def test_too_many_names_and_no_numbers_are_refused():
    f = objective()
    with pytest.raises(ValueError, match="an optimizer may log 20 names, and 'x20' is one more"):
        f.log(**{f"x{number}": 1.0 for number in range(21)})
    with pytest.raises(TypeError):
        f.log(x0=[1.0])
