"""Record a run (its points, its use of the objective, changed global random states) and state how it breaks a rule."""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import zip_longest
from time import monotonic
from typing import Any
from zlib import crc32

import numpy as np
from numpy.typing import ArrayLike

from bench.contract.objective import Objective
from bench.contract.optimizer import Optimizer
from bench.contract.seeds import global_states
from bench.contract.typing import Floats
from bench.helpers.parsing import Json
from bench.sandbox.process import DiedError, LostError, PrintedTooMuchError, TimeExceededError
from bench.sandbox.server import STILL_ASKING, note

OFFERED = {
    "lower", "upper", "integer", "dimension", "budget", "remaining", "nfev", "repair", "initial", "x0", "start_point",
    "handed_out", "stop",
}  # fmt: skip
"""Attributes that the contract offers, and ``nfev``, which is ``budget`` minus ``remaining``."""

_PAUSE = 0.5  # seconds between notes

LET_IT_PASS = "let BudgetExhausted pass: catch Exception, never BaseException or everything (a bare except)"


@dataclass
class RecordedRun:
    """The record of one run.

    Attributes:
        points: (n, d) all evaluated points, in order.
        stop: ``"budget"``, the declared reason, or ``"undeclared"``.
        asked_after: how many times it called the objective again after BudgetExhausted was raised.
        reached: attributes of the objective that it read or set although the contract does not offer them.
        touched: the global random states that it left changed.
    """

    points: Floats = field(default_factory=lambda: np.empty((0, 0)))
    stop: str = "undeclared"
    asked_after: int = 0
    reached: set[str] = field(default_factory=set)
    touched: tuple[str, ...] = ()

    def course(self) -> list[int]:
        """Return a hash of every point, in the order of evaluation."""
        return [crc32(point.tobytes()) for point in self.points]


class ViolationError(Exception):
    """The optimizer breaks the rule: what was observed, and how to fix it."""

    def __init__(self, finding: str, remedy: str) -> None:
        super().__init__(finding)
        self.finding, self.remedy = finding, remedy


def expect_same(one: list[int], other: list[int], finding: str, remedy: str) -> None:
    """Raise ViolationError, naming the first evaluation that differs, unless both courses of runs are equal."""
    if one != other:
        first = next(i for i, (a, b) in enumerate(zip_longest(one, other), 1) if a != b)
        raise ViolationError(f"{finding} (from evaluation {first} on)", remedy)


LOST = (TimeExceededError, PrintedTooMuchError, DiedError, LostError)
"""How an optimizer may lose the process that it runs in."""


def explain_lost_process(
    error: TimeExceededError | PrintedTooMuchError | DiedError | LostError, noted: Json
) -> tuple[str, str]:
    """Return the finding on an optimizer that hung, printed too much or ended its process, and how to fix it.

    Args:
        error: how the process was lost.
        noted: the last note of its :class:`Progress`; it may have sent another.
    """
    whole = isinstance(noted, list) and [type(count) for count in noted] == [int, int]
    made, budget = noted if whole else (0, 0)
    if isinstance(error, DiedError) and error.code == STILL_ASKING:
        return f"it calls the objective for ever after its budget of {budget} is spent", LET_IT_PASS
    if isinstance(error, DiedError):
        remedy = "raise an exception where it cannot go on; a signal means a crash in compiled code"
        return f"it ended the process that it ran in ({error})", remedy
    if isinstance(error, LostError):
        return "it stopped the process that it ran in", "send no signals"
    if isinstance(error, PrintedTooMuchError):
        return "it printed without end", "print and log nothing; switch off the messages of the libraries that you call"
    if budget and made == budget:
        remedy = f"{LET_IT_PASS}; or look for a loop that does not call the objective"
        return f"it did not end within {error}, after its budget of {budget} was spent", remedy
    remedy = "look for a loop that never calls the objective, for a lock that is never released, or for slow code"
    return f"it did not end within {error}, after {made} of {budget or 'its'} evaluations", remedy


class Progress:
    """Note the evaluations that one run has made, and its budget, for the owner of this process, if there is one.

    A note is sent at the begin and at the end of the budget, and at most twice a second between them.
    """

    def __init__(self, budget: int) -> None:
        self._budget, self._due = budget, 0.0
        self.report(0)

    def report(self, made: int) -> None:
        """Note the number of evaluations made, unless another was noted a moment ago."""
        now = monotonic()
        if now >= self._due or made >= self._budget:
            self._due = now + _PAUSE
            note([made, self._budget])


class ObservedOptimizer(Optimizer):
    """An optimizer whose use of the objective is recorded in ``run``."""

    def __init__(self, optimizer: Optimizer, run: RecordedRun, progress: Progress) -> None:
        self._optimizer, self._run, self._progress = optimizer, run, progress
        self.returned = False

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Run the optimizer on a stand-in for the objective."""
        lower, upper = objective.lower.copy(), objective.upper.copy()
        try:
            self._optimizer.minimize(_ObjectiveProxy(objective, self._run, self._progress), rng)  # type: ignore[arg-type]
            self.returned = True
        finally:
            if not (np.array_equal(lower, objective.lower) and np.array_equal(upper, objective.upper)):
                self._run.reached.add("the values of lower and upper")


class _ObjectiveProxy:
    """Pass everything on to an objective, and record what an optimizer should not use.

    A name that no objective has is not recorded: tools that inspect an object ask for many such names.
    """

    __slots__ = ("_objective", "_progress", "_reached")

    def __init__(self, objective: Objective, run: RecordedRun, progress: Progress) -> None:
        for name, value in (("_objective", objective), ("_reached", run.reached), ("_progress", progress)):
            object.__setattr__(self, name, value)

    @property  # type: ignore[misc]
    def __class__(self) -> type:  # isinstance takes it for what it stands for
        return Objective

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._objective, name)
        if name not in OFFERED and not name.startswith("__"):
            self._reached.add(name)
        return value

    def __setattr__(self, name: str, value: object) -> None:
        self._reached.add(name)
        setattr(self._objective, name, value)

    def __call__(self, x: ArrayLike) -> object:
        values = self._objective(x)
        self._progress.report(self._objective.nfev)
        return values


@contextmanager
def seeded_global_states(seed: int) -> Iterator[list[str]]:
    """Seed the global random states and restore them afterwards; the list then names those that were changed."""
    changed: list[str] = []
    before = random.getstate(), np.random.get_state()  # noqa: NPY002
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002
    seeded = global_states()
    try:
        yield changed
    finally:
        changed += [name for name, state in global_states().items() if state != seeded[name]]
        random.setstate(before[0])
        np.random.set_state(before[1])  # noqa: NPY002
