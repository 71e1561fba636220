"""Problems with one defect each, beside those of the tests; written before they were run."""

import time

import numpy as np

from bench import Problem

HOME = np.array([1.0, 2.0, 3.0])


class Sphere(Problem):
    """A shifted sphere with a constraint."""

    name, variables = "sphere", ("a", "b", "c")
    lower, upper = np.full(3, -5.0), np.full(3, 4.0)
    optimum, optimum_point = 0.0, HOME

    def evaluate(self, x):
        return ((x - HOME) ** 2).sum(axis=1)

    def violations(self, x):
        return -1 - x[:, :1]


class Cached(Sphere):
    """Keeps values by the point to three digits."""

    def __init__(self):
        self.known = {}

    def evaluate(self, x):
        values = super().evaluate(x)
        keys = [tuple(row) for row in np.round(x, 3)]
        return np.array([self.known.setdefault(key, value) for key, value in zip(keys, values, strict=True)])


class Ageing(Sphere):
    """Is worse by the hour."""

    optimum = optimum_point = None

    def evaluate(self, x):
        return super().evaluate(x) + int(time.time() / 3600)


class WrongSide(Sphere):
    """Has a constraint of the other sign."""

    def violations(self, x):
        return 1 + x[:, :1]


class Undefined(Sphere):
    """Has no value in half a per cent of the box."""

    def evaluate(self, x):
        with np.errstate(invalid="ignore"):
            return super().evaluate(x) + 0 * np.sqrt(x[:, 0] + 5 - 0.045)


class OneCoarse(Sphere):
    """Has one of its variables pass through float32."""

    def evaluate(self, x):
        x = x.copy()
        x[:, 1] = x[:, 1].astype(np.float32)
        return super().evaluate(x)
