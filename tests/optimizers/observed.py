"""Problems that keep what they are asked for, in boxes that are not symmetric and do not hold the origin."""

import numpy as np

from bench import FunctionProblem

OPTIMUM = np.array([2.3, 6.1, -3.3])
LOWER, UPPER, BEST = np.array([1.0, -7.0, 20.0]), np.array([4.0, -2.0, 80.0]), np.array([1.7, -6.1, 33.0])


class Watched(FunctionProblem):
    """A sphere, which keeps the batches it evaluates."""

    def __init__(self, fun=lambda x: ((x - OPTIMUM) ** 2).sum(axis=1)):
        super().__init__(fun, [1.0, 2.0, -7.0], [5.0, 9.0, -1.0], name="watched")
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


def trace(result):
    return result.trace.evaluations.tolist(), result.trace.values.tolist()
