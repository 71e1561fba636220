"""The objective: counting, the hard budget, the trace, the box, the streams, and one private copy of the points."""

import sys
import threading
from contextlib import contextmanager
from functools import partial
from random import Random

import numpy as np
import pytest

import bench
from bench import BudgetExhausted
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

    monkeypatch.setattr("bench.contract.objective.perf_counter", lambda: now)
    f = objective(Slow(sphere, [0], [1], vectorized=True))
    f([0.5])
    take(16.0)  # the optimizer's own work
    f(f.initial(3))
    assert f.objective_s == 4.0
    assert now == 28.0


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
