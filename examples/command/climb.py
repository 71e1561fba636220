"""The search of the programs here as a plug-in in Python: its trials are equal to theirs to the last bit."""

import numpy as np


class Climb:
    """A (1+1) search with the one-fifth rule."""

    def __init__(self, objective, rng):
        self.box, self.x, self.f, self.step = objective, objective.initial(1), np.inf, 0.2
        self.seed = float(rng.integers(1, 2**31 - 1))

    def ask(self, n):  # noqa: ARG002 - there is one point in each generation
        """Return the first point, then one near the best."""
        if self.f == np.inf:
            return self.x
        moved = self.x.copy()
        for j, width in enumerate(self.box.upper - self.box.lower):
            self.seed = 16807 * self.seed % 2147483647  # the generator MINSTD, which is exact in double precision
            moved[0, j] += self.step * width * (2 * (self.seed / 2147483647) - 1)
        return np.minimum(np.maximum(moved, self.box.lower), self.box.upper)

    def tell(self, x, f):
        """Go on from a point that is no worse."""
        if self.f < np.inf:
            self.step *= 1.5 if f <= self.f else 0.9036020036098449
        if f <= self.f:
            self.x, self.f = x, f
