"""Optimizers that break one rule of the contract each, as strangers' optimizers do."""

import ctypes
import functools
import inspect
import itertools
import json
import os
import stat
import struct
import sys
import threading
import time
import warnings
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from bench import BudgetExhausted, Objective, Optimizer, parameter


class Walker(Optimizer):
    """What most of them are but for their fault: steps from point to point, repaired."""

    def minimize(self, objective, rng):
        x = objective.initial(4)
        while True:
            f = objective(x)
            x = self.move(x, f, objective, rng)

    def move(self, x, f, objective, rng):
        span = objective.upper - objective.lower
        return objective.repair(x + 0.1 * span * rng.standard_normal(x.shape))


@dataclass(frozen=True)
class Sound(Walker):
    """None."""

    agents: int | None = parameter(4, minimum=1)
    way: Literal["far", "near"] = "far"


# --- parameters ---


@dataclass
class Thawed(Walker):
    step: float = 0.1


class Plain(Walker):
    step = 0.1


@dataclass(frozen=True)
class Greedy(Walker):
    step: float = 0.1

    def __post_init__(self):
        pass


@dataclass(frozen=True)
class Hasty(Walker):
    step: float = 0.1

    def __post_init__(self):
        if self.step < 0:
            raise ValueError("negative")
        super().__post_init__()


@dataclass(frozen=True)
class Empty(Walker):
    agents: int = 4


@dataclass(frozen=True)
class Crowded(Walker):
    """Draws two others than an agent and than each other, which it says nowhere."""

    agents: int = parameter(10, minimum=1)

    def minimize(self, objective, rng):
        rng.choice(self.agents, 3, replace=False)
        super().minimize(objective, rng)


@dataclass(frozen=True)
class Demanding(Walker):
    step: float


class Undecorated(Sound):
    step: float = 0.1


@dataclass(frozen=True)
class Abstract(Optimizer):
    step: float = 0.1


@dataclass(frozen=True)
class Misfit(Walker):
    step: int = 0.5


# --- the run and its budget ---


@dataclass(frozen=True)
class Broken(Walker):
    def move(self, x, f, objective, rng):
        raise ZeroDivisionError("by zero\nand more")


@dataclass(frozen=True)
class Idle(Optimizer):
    def minimize(self, objective, rng):
        pass


@dataclass(frozen=True)
class Stubborn(Walker):
    """Catches everything, three times over."""

    def minimize(self, objective, rng):
        for _ in range(3):
            try:
                super().minimize(objective, rng)
            except BaseException:
                continue


@dataclass(frozen=True)
class Endless(Optimizer):
    """Catches everything, for ever."""

    def minimize(self, objective, rng):
        while True:
            with suppress(BaseException):
                objective(objective.initial(4))


@dataclass(frozen=True)
class Rounding(Optimizer):
    """Drops what is left of the budget after whole generations."""

    agents: int = parameter(4, minimum=1)

    def minimize(self, objective, rng):
        for _ in range(objective.budget // self.agents):
            objective(objective.initial(self.agents))


@dataclass(frozen=True)
class Hanging(Walker):
    """Waits for ever once its budget is spent."""

    def minimize(self, objective, rng):
        try:
            super().minimize(objective, rng)
        except BudgetExhausted:
            while True:
                time.sleep(0.1)


@dataclass(frozen=True)
class Stuck(Walker):
    """Never asks for a value in a narrow box."""

    def minimize(self, objective, rng):
        while objective.upper[0] - objective.lower[0] < 0.01:
            time.sleep(0.1)
        super().minimize(objective, rng)


@dataclass(frozen=True)
class Quitting(Walker):
    """Ends the process on values that are all equal."""

    def move(self, x, f, objective, rng):
        if f.min() == f.max() == 0:
            os._exit(3)
        return super().move(x, f, objective, rng)


@dataclass(frozen=True)
class Interrupting(Walker):
    """Raises what is no Exception in one dimension."""

    def move(self, x, f, objective, rng):
        if objective.dimension == 1:
            raise KeyboardInterrupt
        return super().move(x, f, objective, rng)


@dataclass(frozen=True)
class Crashing(Walker):
    """Reads from address 0 in one dimension."""

    def move(self, x, f, objective, rng):
        if objective.dimension == 1:
            ctypes.string_at(0)
        return super().move(x, f, objective, rng)


@dataclass(frozen=True)
class Forging(Walker):
    """Replaces the harness's own function in one dimension."""

    def move(self, x, f, objective, rng):
        if objective.dimension == 1:
            vars(sys.modules["bench.check.checker"])["_judge"] = lambda packed, name: {"check": name, "passed": "yes"}
        return super().move(x, f, objective, rng)


@dataclass(frozen=True)
class Answering(Walker):
    """Writes an answer of its own into every open socket in one dimension."""

    def move(self, x, f, objective, rng):
        if objective.dimension == 1:
            answer = json.dumps(["value", None]).encode()
            for number in (int(entry.name) for entry in Path("/dev/fd").iterdir()):
                with suppress(OSError):
                    if stat.S_ISSOCK(os.fstat(number).st_mode):
                        os.write(number, struct.pack("<QQ", 10**6, len(answer)) + answer)
        return super().move(x, f, objective, rng)


@dataclass(frozen=True)
class Surplus(Walker):
    """Starts with one more point than it says."""

    agents: int = parameter(6, minimum=1)

    def minimize(self, objective, rng):
        x = objective.initial(self.agents + 1)
        while True:
            x = self.move(x, objective(x), objective, rng)


# --- boxes, dimensions and values ---


@dataclass(frozen=True)
class Escaping(Walker):
    def move(self, x, f, objective, rng):
        return x + 0.1 * (objective.upper - objective.lower) * rng.standard_normal(x.shape)


@dataclass(frozen=True)
class Planar(Walker):
    """Needs two variables."""

    def move(self, x, f, objective, rng):
        x[:, 1] += 1e-3
        return super().move(x, f, objective, rng)


@dataclass(frozen=True)
class Finite(Walker):
    """Raises where a value is infinite."""

    def move(self, x, f, objective, rng):
        np.histogram(f)
        return super().move(x, f, objective, rng)


@dataclass(frozen=True)
class Ranging(Walker):
    """Divides by the range of values."""

    def move(self, x, f, objective, rng):
        with np.errstate(all="ignore"):
            weight = (f - f.min()) / (f.max() - f.min())
        return np.clip(x * weight[:, np.newaxis], objective.lower, objective.upper)


@dataclass(frozen=True)
class Content(Walker):
    """Returns in silence from a plateau."""

    def minimize(self, objective, rng):
        if not np.ptp(objective(objective.initial(4))):
            return
        super().minimize(objective, rng)


# --- manners ---


@dataclass(frozen=True)
class Spying(Walker):
    def minimize(self, objective, rng):
        objective(objective._problem.lower + 0 * objective.initial(2))
        super().minimize(objective, rng)


@dataclass(frozen=True)
class Boasting(Walker):
    def minimize(self, objective, rng):
        super().minimize(objective, rng) if objective.fun else None


@dataclass(frozen=True)
class Stretching(Walker):
    def minimize(self, objective, rng):
        objective.upper = objective.upper
        super().minimize(objective, rng)


@dataclass(frozen=True)
class Knowing(Walker):
    """Finds the problem through the objective's method."""

    def minimize(self, objective, rng):
        problem = objective.repair.__self__._problem
        objective(objective.initial(1 + (problem.optimum is not None)))
        super().minimize(objective, rng)


@dataclass(frozen=True)
class Chatty(Walker):
    def move(self, x, f, objective, rng):
        print("generation", f.min())
        return super().move(x, f, objective, rng)


@dataclass(frozen=True)
class Loud(Walker):
    """Writes below Python, as libraries in C do."""

    def move(self, x, f, objective, rng):
        os.write(2, b"iterating\n")
        return super().move(x, f, objective, rng)


@dataclass(frozen=True)
class Littering(Walker):
    def move(self, x, f, objective, rng):
        Path("outwalker.log").write_text("x")
        return super().move(x, f, objective, rng)


@dataclass(frozen=True)
class Threaded(Walker):
    """Starts a thread a run that waits for work for ever."""

    def minimize(self, objective, rng):
        threading.Thread(target=threading.Event().wait, daemon=True).start()
        super().minimize(objective, rng)


# --- sound, though it may not look so ---


@dataclass(frozen=True)
class Deterministic(Optimizer):
    """Halves its steps along a diagonal; needs no seed."""

    def minimize(self, objective, rng):
        for k in itertools.count(1):
            share = (k * 0.618033988749895) % 1
            objective(objective.lower + share * (objective.upper - objective.lower))


@dataclass(frozen=True)
class Pattern(Walker):
    """Steps from a random start by a fixed pattern."""

    def move(self, x, f, objective, rng):
        return objective.repair(0.9 * x + 0.1 * x[f.argmin()])


@dataclass(frozen=True)
class Tired(Walker):
    """Stops early and says so."""

    def minimize(self, objective, rng):
        for _ in range(20):
            objective(objective.initial(1))
        objective.stop("tired")


@dataclass(frozen=True)
class Careful(Walker):
    """Catches the end of its budget, cleans up and returns; and looks the objective over as tools do."""

    def minimize(self, objective, rng):
        functools.wraps(objective)(lambda x: x)
        inspect.signature(objective)
        hasattr(objective, "_vectorized")
        assert isinstance(objective, Objective)
        with suppress(BudgetExhausted):
            super().minimize(objective, rng)


@dataclass(frozen=True)
class Outdated(Walker):
    def minimize(self, objective, rng):
        warnings.warn("deprecated", stacklevel=1)
        super().minimize(objective, rng)
