"""Problems that keep what they are asked for, in boxes that are not symmetric and do not hold the origin."""

import numpy as np

from bench import FunctionProblem

OPTIMUM = np.array([2.3, 6.1, -3.3])
LOWER, UPPER, BEST = np.array([1.0, -7.0, 20.0]), np.array([4.0, -2.0, 80.0]), np.array([1.7, -6.1, 33.0])


def sphere(x):
    return ((x - OPTIMUM) ** 2).sum(axis=1)


class Watched(FunctionProblem):
    """A function that keeps the batches it evaluates."""

    def __init__(self, fun=sphere, lower=(1.0, 2.0, -7.0), upper=(5.0, 9.0, -1.0), **options):
        super().__init__(fun, lower, upper, name="watched", **options)
        self.batches = []

    def evaluate(self, x):
        self.batches.append(x.copy())
        return super().evaluate(x)


def bowl(x):
    d = x.shape[1]
    return (((x - BEST[:d]) / (UPPER - LOWER)[:d]) ** 2).sum(axis=1)


class Recorded(FunctionProblem):
    """A function of up to three variables, which keeps the points and the sizes of the batches."""

    def __init__(self, function=bowl, d=3):
        super().__init__(function, LOWER[:d], UPPER[:d])
        self.points, self.sizes = [], []

    def evaluate(self, x):
        self.points.append(x)
        self.sizes.append(len(x))
        return super().evaluate(x)


class Capped(Recorded):
    """Feasible where the first variable is at most 2."""

    def repair(self, x):
        return np.clip(x, self.lower, np.minimum(self.upper, 2.0 + 100.0 * (np.arange(3) > 0)))


def trace(result):
    return result.trace.evaluations.tolist(), result.trace.values.tolist()
