"""Record a run: its points, its use of the objective, and the global random states that it changed."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any
from zlib import crc32

import numpy as np
from numpy.typing import ArrayLike

from bench.objective import Objective
from bench.optimizer import Optimizer
from bench.problem import Floats
from bench.sandbox.process import Pulse
from bench.seeds import global_states

OFFERED = {"lower", "upper", "dimension", "budget", "remaining", "evaluations", "repair", "initial", "stop"}
"""Attributes that the contract offers, and ``evaluations``, which is ``budget`` minus ``remaining``."""


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


class ObservedOptimizer(Optimizer):
    """An optimizer whose use of the objective and the generator is recorded.

    Args:
        optimizer: what is run.
        run: the record.
        pulse: called with the evaluations made and the budget after every call of the objective, if given.
    """

    def __init__(self, optimizer: Optimizer, run: RecordedRun, pulse: Pulse | None) -> None:
        self._optimizer, self._run, self._pulse = optimizer, run, pulse
        self.returned = False

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Run the optimizer on a stand-in for the objective."""
        lower, upper, before = objective.lower.copy(), objective.upper.copy(), _state(rng)
        try:
            self._optimizer.minimize(_ObjectiveProxy(objective, self._run, self._pulse), rng)  # type: ignore[arg-type]
            self.returned = True
        finally:
            self._run.drew = _state(rng) != before
            if not (np.array_equal(lower, objective.lower) and np.array_equal(upper, objective.upper)):
                self._run.reached.add("the values of lower and upper")


class _ObjectiveProxy:
    """Pass everything on to an objective, and record what an optimizer should not use.

    A name that no objective has is not recorded: tools that inspect an object ask for many such names.
    """

    __slots__ = ("_objective", "_pulse", "_reached")

    def __init__(self, objective: Objective, run: RecordedRun, pulse: Pulse | None) -> None:
        for name, value in (("_objective", objective), ("_reached", run.reached), ("_pulse", pulse)):
            object.__setattr__(self, name, value)

    @property  # type: ignore[misc]
    def __class__(self) -> type:  # isinstance takes it for what it stands for
        return Objective

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._objective, name)
        if name not in OFFERED and not name.startswith("__"):
            self._reached.add(name)
        return value

    def __setattr__(self, name: str, value: Any) -> None:
        self._reached.add(name)
        setattr(self._objective, name, value)

    def __call__(self, x: ArrayLike) -> Any:
        values = self._objective(x)
        if self._pulse is not None:
            self._pulse(self._objective.evaluations, self._objective.budget)
        return values


def _state(rng: np.random.Generator) -> str:
    return f"{rng.bit_generator.state} {getattr(rng.bit_generator.seed_seq, 'n_children_spawned', 0)}"


@contextmanager
def seeded_global_states(seed: int) -> Iterator[Callable[[], tuple[str, ...]]]:
    """Seed the global random states, yield a function that names those that have changed, and restore all of them."""
    before = random.getstate(), np.random.get_state()  # noqa: NPY002
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002
    seeded = global_states()
    try:
        yield lambda: tuple(name for name, state in global_states().items() if state != seeded[name])
    finally:
        random.setstate(before[0])
        np.random.set_state(before[1])  # noqa: NPY002
