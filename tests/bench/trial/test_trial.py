"""One trial: how it ends, what its result holds, and its row in the store."""

import os
import subprocess
import sys
from dataclasses import dataclass
from math import inf, nan
from types import SimpleNamespace

import numpy as np
import pytest

from bench import FunctionProblem, Optimizer
from bench.helpers.errors import ProblemError
from bench.trial.trial import doubt, search
from tests.bench.made import result


class Described(FunctionProblem):
    def describe(self, x):
        return {"norm": np.abs(x).sum()}


SPHERE = Described(lambda x: (x**2).sum(axis=1), [-1, -1], [1, 1], variables=("a", "b"))


@dataclass(frozen=True)
class Drawing(Optimizer):
    """Evaluates ``points`` random points and returns, or goes on for ever."""

    points: int | None = None
    reason: str = ""

    def minimize(self, objective, rng):
        if self.reason:
            objective.stop(self.reason)
        if self.points is None:
            while True:
                objective(objective.initial(4))
        if self.points:
            objective(objective.initial(self.points))


@pytest.mark.parametrize(
    ("optimizer", "stop", "nfev"),
    [
        (Drawing(), "budget", 10),
        (Drawing(reason="tolfun"), "budget", 10),
        (Drawing(points=10, reason="tolfun"), "budget", 10),
        (Drawing(points=4, reason="tolfun"), "tolfun", 4),
        (Drawing(points=4), "undeclared", 4),
    ],
)
def test_a_trial_ends_by_its_budget_a_declared_reason_or_without_one(optimizer, stop, nfev):
    result = search(SPHERE, optimizer, 10, seed=3)
    assert (result.stop, result.nfev, result.seed) == (stop, nfev, 3)
    assert result.fun == (result.x**2).sum() == result.trace.values[-1]


def test_times_are_those_of_the_search(monkeypatch):
    clocks = {"perf_counter": iter([1.0, 8.0]), "process_time": iter([2.0, 5.0])}
    for name, times in clocks.items():
        monkeypatch.setattr(f"bench.trial.trial.{name}", times.__next__)
    monkeypatch.setattr("bench.contract.objective.perf_counter", iter([0.0, 2.5]).__next__)
    found = search(SPHERE, Drawing(points=4), 10, seed=0)
    assert found.cost[:3] == (7.0, 3.0, 2.5)
    assert (found.cost.overhead_s, found.time) == (4.5, 7.0)


FORKED = """
import os
import numpy as np
from bench import FunctionProblem
from bench.trial.trial import search
class Holding:
    def minimize(self, objective, rng):
        objective(objective.initial(10) + 0 * np.ones(5_000_000)[0])  # 40 MB
np.ones(8_000_000)  # 64 MB, which are free again when the process is forked
if not os.fork():
    print(search(FunctionProblem(np.ravel, [0], [1], vectorized=True), Holding(), 10, 0).cost.memory_mb, flush=True)
    os._exit(0)
os.wait()
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are forked on POSIX alone")
def test_the_memory_of_a_trial_is_that_of_its_own_process_and_not_what_its_parent_once_had():
    done = subprocess.run([sys.executable, "-c", FORKED], capture_output=True, text=True, check=True)
    assert 35 < float(done.stdout) < 64


@pytest.mark.skipif(sys.platform == "win32", reason="Windows counts memory in another way")
def test_no_memory_is_negative_where_the_system_reports_less_than_before(monkeypatch):
    peaks = iter([2000, 1872])  # kB, as Linux 6.18 did on a busy machine
    monkeypatch.setattr("resource.getrusage", lambda who: SimpleNamespace(ru_maxrss=next(peaks)))
    assert search(SPHERE, Drawing(3), 10, 0).cost.memory_mb == 0


def raises_beyond(limit):
    """Return a problem in a box of [-1, 1]^2 that cannot be evaluated where its first variable exceeds a limit."""

    def fun(x):
        if not (x[:, 0] <= limit).all():
            raise ValueError("no convergence")
        return (x**2).sum(axis=1)

    return FunctionProblem(fun, [-1, -1], [1, 1])


@dataclass(frozen=True)
class At(Optimizer):
    """Evaluates one point, may catch what is raised there, and goes on at 0."""

    x: float
    catches: bool = False
    batch: bool = False

    def minimize(self, objective, rng):
        point = np.array([self.x, 0.0])
        try:
            objective(point[np.newaxis] if self.batch else point)
        except ValueError:
            if not self.catches:
                raise KeyError("another one") from None
        objective(np.zeros(2))


@pytest.mark.parametrize("catches", [False, True])
@pytest.mark.parametrize("batch", [False, True])
def test_what_a_problem_raises_in_its_box_is_the_problems_fault_whatever_the_optimizer_does(catches, batch):
    with pytest.raises(ProblemError, match=r"^ValueError: no convergence$") as caught:
        search(raises_beyond(0.5), At(0.75, catches, batch), 10, seed=1)
    assert isinstance(caught.value.raised, ValueError)


@pytest.mark.parametrize("batch", [False, True])
def test_what_a_problem_raises_outside_its_box_or_at_no_number_is_the_optimizers(batch):
    for x in (1.5, np.nan):
        assert search(raises_beyond(1.0), At(x, catches=True, batch=batch), 10, seed=1).fun == 0
        with pytest.raises(KeyError):
            search(raises_beyond(1.0), At(x, batch=batch), 10, seed=1)


# The value of the best point


def doubts(fun, function, x=(0.5, 0.25)):
    """What is said of a result of that value at the point, on a problem of this function."""
    return doubt(result(x, fun), FunctionProblem(function, [-1.0] * 2, [1.0] * 2))


@pytest.mark.parametrize(
    ("fun", "value"),
    [
        (0.125, 0.125), (0.125 * (1 + 0.9e-9), 0.125), (0.125 * (1 - 0.9e-9), 0.125), (-0.0, 0.0), (inf, inf),
        (inf, nan),
    ],
)  # fmt: skip
def test_a_value_that_the_best_point_has_is_not_doubted(fun, value):
    assert doubts(fun, lambda x: np.full(len(x), value)) == ""


@pytest.mark.parametrize(
    ("fun", "value"),
    [
        (0.125 * (1 + 1.1e-9), 0.125), (0.125 * (1 - 1.1e-9), 0.125), (-0.125, 0.125), (1e-300, 2e-300), (1e-17, 0.0),
        (0.0, 100.0), (0.0, inf), (0.0, nan), (1e300, 1.0), (inf, 0.125),
    ],
)  # fmt: skip
def test_a_value_that_the_best_point_does_not_have_is_doubted(fun, value):
    assert f"the best value is {fun!r}, and its point has" in doubts(fun, lambda x: np.full(len(x), value))


def test_what_the_problem_raises_at_a_best_point_is_its_own_error():
    def fail(x):
        raise ZeroDivisionError("no mass")

    problem = FunctionProblem(fail, [-1.0] * 2, [1.0] * 2, vectorized=True)
    with pytest.raises(ProblemError, match="ZeroDivisionError: no mass"):
        doubt(result([0.0, 0.0], 0.0), problem)
