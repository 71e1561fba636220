"""The search of the programs here as a plug-in in Python: its trials are equal to theirs to the last bit."""

from dataclasses import dataclass

import numpy as np

from bench import AskTell


@dataclass(frozen=True)
class Climb(AskTell):
    """A (1+1) search with the one-fifth rule."""

    def start(self, objective, rng):
        self.box, self.x, self.f, self.step = objective, objective.initial(1), None, 0.2
        self.seed = float(rng.integers(1, 2**31 - 1))

    def uniform(self):
        self.seed = 16807 * self.seed % 2147483647  # the generator MINSTD, which is exact in double precision
        return self.seed / 2147483647

    def ask(self, n):
        if self.f is None:
            return self.x
        drawn = np.array([self.uniform() for _ in range(self.box.dimension)])
        moved = self.x + self.step * (self.box.upper - self.box.lower) * (2 * drawn - 1)
        return np.minimum(np.maximum(moved, self.box.lower), self.box.upper)

    def tell(self, x, f):
        if self.f is None:
            self.f = f
            return
        self.step *= 1.5 if f <= self.f else 0.9036020036098449
        if f <= self.f:
            self.x, self.f = x, f
