"""Optimizers of which equal seeds give unlike runs, or a copy gives another run; and one that learns nothing."""

import itertools
import os
import random
import threading
import time
from dataclasses import dataclass, field

import numpy as np

from tests.bench.check.faulty import Sound, Walker


@dataclass(frozen=True)
class Clocked(Walker):
    def move(self, x, f, objective, rng):
        return super().move(x, f, objective, np.random.default_rng(time.perf_counter_ns()))


_made = itertools.count()


@dataclass(frozen=True)
class Counting(Walker):
    """Keeps state in its module."""

    def minimize(self, objective, rng):
        super().minimize(objective, np.random.default_rng(next(_made)))


@dataclass(frozen=True)
class Hashing(Walker):
    """Takes its moves in the order of a set of texts."""

    def move(self, x, f, objective, rng):
        for word in {"explore", "exploit", "encircle", "attack", "retreat", "dive", "soar", "swim"}:
            x = x * (1 + len(word) / 1000) + 0.001 * ord(word[-1])
        return super().move(x, f, objective, rng)


@dataclass(frozen=True)
class Foreign(Walker):
    """Depends on its process."""

    def move(self, x, f, objective, rng):
        return super().move(x + 1e-6 * os.getpid(), f, objective, rng)


@dataclass(frozen=True)
class Fixed(Walker):
    """Moves by a generator of its own with a seed of its own, from the starts of the trial."""

    def minimize(self, objective, rng):
        super().minimize(objective, np.random.default_rng(7))


@dataclass(frozen=True)
class Cached(Walker):
    """Keeps the first start in its class."""

    start = None

    def minimize(self, objective, rng):
        if Cached.start is None:
            Cached.start = objective.initial(4)
        if objective.dimension == Cached.start.shape[1]:
            objective(objective.repair(Cached.start))
        super().minimize(objective, rng)


@dataclass(frozen=True)
class Remembering(Walker):
    def minimize(self, objective, rng):
        object.__setattr__(self, "_start", getattr(self, "_start", objective.initial(4)))
        if objective.dimension == self._start.shape[1]:
            objective(self._start)
        super().minimize(objective, rng)


@dataclass(frozen=True)
class Adapting(Walker):
    step: float = 0.1

    def minimize(self, objective, rng):
        object.__setattr__(self, "step", self.step * 2)
        super().minimize(objective, rng)


@dataclass(frozen=True)
class Locked(Walker):
    lock: object = field(default_factory=threading.Lock, compare=False, repr=False)


@dataclass(frozen=True)
class Forgetful(Walker):
    step: float = 0.1

    def __reduce__(self):
        return Forgetful, (0.1,)


@dataclass(frozen=True)
class Changeling(Sound):
    def __reduce__(self):
        return Sound, ()


@dataclass(frozen=True)
class Legacy(Walker):
    def move(self, x, f, objective, rng):
        return objective.repair(x + 0.01 * np.random.standard_normal(x.shape))  # noqa: NPY002


@dataclass(frozen=True)
class Peeking(Walker):
    """Uses Python's random numbers and puts their state back."""

    def move(self, x, f, objective, rng):
        state = random.getstate()
        x = x + random.random()
        random.setstate(state)
        return super().move(x, f, objective, rng)


@dataclass(frozen=True)
class Timed(Walker):
    """Begins anew after a minute."""

    def minimize(self, objective, rng):
        x, began = objective.initial(4), time.monotonic()
        while True:
            x = self.move(x, objective(x), objective, rng)
            x = x if time.monotonic() - began < 60 else objective.initial(4)


@dataclass(frozen=True)
class Stale(Walker):
    """Follows the best of its first points for ever."""

    def minimize(self, objective, rng):
        x = objective.initial(4)
        x[:] = x[objective(x).argmin()]
        while True:
            objective(self.move(x, None, objective, rng))
