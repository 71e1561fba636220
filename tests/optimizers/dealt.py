"""Runs whose random numbers, start and end are given, for following a generation by hand."""

import numpy as np
import pytest

from bench import BudgetExhausted


class Dealt:
    """A generator whose draws are given: for each method the arrays it returns, in turn, in the shapes asked for."""

    def __init__(self, **hands):
        self.hands = {method: list(arrays) for method, arrays in hands.items()}

    def _deal(self, method, size):
        given = np.array(self.hands[method].pop(0))
        assert given.shape == (() if size is None else tuple(np.atleast_1d(size)))
        return given

    def random(self, size=None):
        return self._deal("random", size)

    def standard_normal(self, size=None):
        return self._deal("standard_normal", size)

    def uniform(self, low, high, size=None):
        self.asked = low, high
        return self._deal("uniform", size)

    def integers(self, *_, size=None, **__):
        return self._deal("integers", size)


class Watched:
    """An objective in the box +-``bound`` that starts from given points and ends after ``batches`` evaluations."""

    def __init__(self, f, start, bound, generations, batches):
        start = np.array(start, dtype=float)
        self.dimension, self.budget, self.ends, self.seen = start.shape[1], len(start) * generations, batches, []
        self.lower, self.upper = np.full(self.dimension, -bound), np.full(self.dimension, bound)
        self.f, self.start = f, start

    def initial(self, n):
        assert n == len(self.start)
        return self.start

    def repair(self, x):
        return x

    def __call__(self, x):
        self.seen.append(x.copy())
        if len(self.seen) == self.ends:
            raise BudgetExhausted
        return np.array([float(self.f(point)) for point in x])


def watch(optimizer, objective, rng):
    """Return the batches that ``optimizer`` evaluates."""
    with pytest.raises(BudgetExhausted):
        optimizer.minimize(objective, rng)
    return objective.seen
