"""Record a run: its points, its use of the objective, and the global random states that it changed."""

from __future__ import annotations

import os
import random
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any
from zlib import crc32

import numpy as np
from numpy.typing import ArrayLike

from bench.execution.trial_process import STILL_ASKING
from bench.objective import BudgetExhausted, Objective
from bench.optimizer import Optimizer
from bench.problem import Floats, FunctionProblem, Problem
from bench.sandbox.process import Pulse
from bench.seeds import global_states
from bench.trial import solve

OFFERED = frozenset(
    {"lower", "upper", "dimension", "budget", "remaining", "evaluations", "repair", "initial", "stop"}
)  # fmt: skip
"""Attributes that the contract offers, and ``evaluations``, which is ``budget`` minus ``remaining``."""

_MOST_REFUSALS = 10_000  # calls after the end of the budget until the process is ended


@dataclass
class RecordedRun:
    """The record of one run.

    Attributes:
        points: (n, d) all evaluated points, in order.
        stop: ``"budget"``, the declared reason, or ``"undeclared"``.
        asked_after: how many times it called the objective again after BudgetExhausted was raised.
        outside: points outside the box or not finite.
        reached: attributes of the objective that it read or set although the contract does not offer them.
        drew: whether it drew from its generator.
        touched: the global random states that it left changed.
    """

    points: Floats = field(default_factory=lambda: np.empty((0, 0)))
    stop: str = "undeclared"
    asked_after: int = 0
    outside: int = 0
    reached: set[str] = field(default_factory=set)
    drew: bool = False
    touched: tuple[str, ...] = ()

    def course(self) -> list[int]:
        """Return a hash of every point, in the order of evaluation."""
        return [crc32(point.tobytes()) for point in self.points]


def record_run(
    optimizer: Optimizer,
    problem: Problem,
    budget: int,
    *,
    seed: int,
    pulse: Pulse | None = None,
    expendable: bool = False,
    global_seed: int = 0,
) -> RecordedRun:
    """Run the optimizer as a trial does and return the record.

    Args:
        optimizer: what is run.
        problem: what is minimised.
        budget: evaluations it may spend.
        seed: the trial's.
        pulse: called with the evaluations made and the budget after every call of the objective.
        expendable: whether this process may be ended to stop an optimizer that calls the objective for ever.
        global_seed: of Python's and numpy's global random states during the run.
    """
    seen = RecordedRun()
    observed = _ObservedOptimizer(optimizer, seen, pulse, expendable)
    points: list[Floats] = []
    with _global_states(global_seed) as changed:
        try:
            result = solve(_RecordingProblem(problem, points), observed, budget=budget, seed=seed)
        except RuntimeError:
            if points or not observed.returned:
                raise
        else:
            seen.stop, seen.outside = result.stop, result.outside_box
        seen.touched = changed()
    seen.points = np.concatenate(points) if points else np.empty((0, problem.dimension))
    return seen


class _RecordingProblem(FunctionProblem):
    """A problem that records its evaluated points."""

    def __init__(self, problem: Problem, points: list[Floats]) -> None:
        super().__init__(problem.evaluate, problem.lower, problem.upper, name=problem.name, optimum=problem.optimum,
                         variables=problem.variables)  # fmt: skip
        self.repair = problem.repair  # type: ignore[method-assign]
        self._points = points

    def evaluate(self, x: Floats) -> Floats:
        self._points.append(x.copy())
        return super().evaluate(x)


class _ObservedOptimizer(Optimizer):
    """The optimizer, which gets a recording objective."""

    def __init__(self, optimizer: Optimizer, seen: RecordedRun, pulse: Pulse | None, expendable: bool) -> None:
        self.optimizer, self.seen, self.pulse, self.expendable = optimizer, seen, pulse, expendable
        self.returned = False

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        lower, upper, before = objective.lower.copy(), objective.upper.copy(), _state(rng)
        try:
            self.optimizer.minimize(_ObjectiveProxy(objective, self), rng)  # type: ignore[arg-type]
            self.returned = True
        finally:
            self.seen.drew = _state(rng) != before
            if not (np.array_equal(lower, objective.lower) and np.array_equal(upper, objective.upper)):
                self.seen.reached.add("the values of lower and upper")


class _ObjectiveProxy:
    """Pass everything on to an objective, and record what an optimizer should not use.

    A name that no objective has is not recorded: tools that inspect an object ask for many such names.
    """

    __slots__ = ("_ends", "_objective", "_observed")

    def __init__(self, objective: Objective, observed: _ObservedOptimizer) -> None:
        for name, value in (("_objective", objective), ("_observed", observed), ("_ends", [])):
            object.__setattr__(self, name, value)

    @property  # type: ignore[misc]
    def __class__(self) -> type:  # isinstance takes it for what it stands for
        return Objective

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._objective, name)
        if name not in OFFERED and not name.startswith("__"):
            self._observed.seen.reached.add(name)
        return value

    def __setattr__(self, name: str, value: Any) -> None:
        self._observed.seen.reached.add(name)
        setattr(self._objective, name, value)

    def __call__(self, x: ArrayLike) -> Any:
        objective, observed = self._objective, self._observed
        try:
            values = objective(x)
        except BudgetExhausted:
            observed.seen.asked_after = len(self._ends)
            self._ends.append(True)
            if len(self._ends) == 1:
                self._pulse()
            if observed.expendable and len(self._ends) > _MOST_REFUSALS:
                os._exit(STILL_ASKING)
            raise
        self._pulse()
        return values

    def _pulse(self) -> None:
        if self._observed.pulse is not None:
            self._observed.pulse(self._objective.evaluations, self._objective.budget)


def _state(rng: np.random.Generator) -> str:
    return f"{rng.bit_generator.state} {getattr(rng.bit_generator.seed_seq, 'n_children_spawned', 0)}"


@contextmanager
def _global_states(seed: int) -> Iterator[Callable[[], tuple[str, ...]]]:
    """Seed the global random states, yield a function that names those that have changed, and restore all of them."""
    before = random.getstate(), np.random.get_state()  # noqa: NPY002
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002
    seeded = global_states()

    def changed() -> tuple[str, ...]:
        return tuple(name for name, state in global_states().items() if state != seeded[name])

    try:
        yield changed
    finally:
        random.setstate(before[0])
        np.random.set_state(before[1])  # noqa: NPY002
