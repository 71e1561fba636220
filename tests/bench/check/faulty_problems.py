"""Problems that break one rule of the contract each, as strangers' problems do."""

import random
import threading
from pathlib import Path

import numpy as np

from bench import Problem

ROTATION = np.linalg.qr(np.random.default_rng(5).standard_normal((23, 23)))[0]
HOME = np.array([1.0, 2.0, 3.0])


class Sound(Problem):
    """A shifted sphere with a constraint, a repair and its optimum at a claimed point."""

    name, variables = "sound", ("a", "b", "c")
    lower, upper = np.full(3, -5.0), np.full(3, 4.0)
    optimum, repairs = 0.0, True
    optimum_point = HOME

    def evaluate(self, x):
        return self.values(x)

    def values(self, x):
        return ((x - HOME) ** 2).sum(axis=1)

    def violations(self, x):
        return -1 - x[:, :1]

    def repair(self, x):
        return np.clip(x, [-1, -5, -5], self.upper)


class Whole(Sound):
    integer = np.array([True, False, False])


class Noisy(Sound):
    noisy = True

    def evaluate(self, x, rng):
        return self.values(x) + rng.standard_normal(len(x))

    def noiseless(self, x):
        return self.values(x)


class Endless(Sound):
    optimum = np.inf


class Renamed(Sound):
    variables = ("a", "a", "b")


class Halves(Sound):
    integer, lower = np.array([True, False, False]), np.full(3, -4.5)


class Flat(Sound):
    def values(self, x):
        return super().values(x)[:, None]


class Whole32(Sound):
    def values(self, x):
        return super().values(x).astype(np.float32)


class NotANumber(Sound):
    def values(self, x):
        return np.sqrt(x[:, 0] + 4) + super().values(x)


class Bottomless(Sound):
    optimum = optimum_point = None

    def values(self, x):
        with np.errstate(divide="ignore"):
            return np.log(x[:, 0] + 5)


class Rotated(Sound):
    """Its product rounds the values of one row otherwise than those of many."""

    variables = tuple(f"x{i}" for i in range(23))
    lower, upper, optimum, optimum_point = np.full(23, -5.0), np.full(23, 5.0), None, None

    def values(self, x):
        return ((x @ ROTATION) ** 2 * np.logspace(0, 6, 23)).sum(axis=1)

    def repair(self, x):
        return np.clip(x, [-1, *[-5] * 22], self.upper)


class Ranked(Sound):
    optimum = optimum_point = None

    def values(self, x):
        return super().values(x) - super().values(x).mean()


class Counting(Sound):
    optimum = None
    calls = 0

    def values(self, x):
        type(self).calls += 1
        return super().values(x) + type(self).calls


class Loose(Sound):
    def violations(self, x):
        return x[:, :1] - x[:, :1].mean() - 99


class Mute(Noisy):
    def evaluate(self, x, rng):
        return self.values(x)


class Own(Noisy):
    def evaluate(self, x, rng):
        return self.values(x) + np.random.default_rng().standard_normal(len(x))


class Outside(Sound):
    def repair(self, x):
        return np.maximum(x, [-1, -5, -5])


class Restless(Sound):
    def repair(self, x):
        return np.clip(np.clip(x, [-1, -5, -5], self.upper) * 0.9, [-1, -5, -5], self.upper)


class Unrepaired(Sound):
    def repair(self, x):
        return np.clip(x, self.lower, self.upper)


class High(Sound):
    optimum = 20.0


class Misplaced(Sound):
    def values(self, x):
        return ((x - [1.0, 2.0, 2.0]) ** 2).sum(axis=1)


class Hashed(Sound):
    def values(self, x):
        return super().values(x) + hash("sound") % 97

    optimum = optimum_point = None


class Keeping(Sound):
    def describe(self, x):
        self.measure = "the last " + str(x[0])
        return {}


class Unpicklable(Sound):
    def __init__(self):
        self.lock = threading.Lock()


class Drawing(Sound):
    def values(self, x):
        random.random()
        return super().values(x)


class Chatty(Sound):
    def values(self, x):
        print("evaluated", len(x))
        return super().values(x)


class Littering(Sound):
    def values(self, x):
        Path("log.txt").write_text("x")
        return super().values(x)


class Raising(Sound):
    def values(self, x):
        raise RuntimeError("no licence\nfor this host")


class Hanging(Sound):
    def values(self, x):
        while True:
            pass


# --- found by many calls, or by small steps ---


class Coarse(Sound):
    """Returns values that were float32."""

    def values(self, x):
        return super().values(x).astype(np.float32).astype(np.float64)


class CoarsePoints(Sound):
    def values(self, x):
        return super().values(x.astype(np.float32).astype(np.float64))


class CoarseInside(Sound):
    def values(self, x):
        return ((x - HOME).astype(np.float32).astype(np.float64) ** 2).sum(axis=1)


class RoundedPoints(Sound):
    """Takes points to six digits, as a cache of them does."""

    def values(self, x):
        return super().values(np.round(x, 6))


class Idle(Sound):
    """Leaves out its last variable."""

    optimum_point = None

    def values(self, x):
        return super().values(x[:, [0, 1, 1]])

    optimum = None


class Chunked(Sound):
    """Wrong in a batch of 37."""

    def values(self, x):
        return super().values(x) + (len(x) == 37) * 1e-3


class Wide(Sound):
    def values(self, x):
        return super().values(x) + (len(x) > 200) * 1e-12


class Padded(Sound):
    """Loses the last row of an odd batch above eight."""

    def values(self, x):
        values = super().values(x)
        if len(x) % 2 and len(x) > 8:
            values[-1] = values[-2]
        return values


class Tiring(Sound):
    optimum = optimum_point = None

    def __init__(self):
        self.calls = 0

    def values(self, x):
        self.calls += 1
        return super().values(x) + (self.calls > 1000) * 1e-9


class Drifting(Sound):
    """Gains a rounding error every hundred calls."""

    def __init__(self):
        self.calls = 0

    def values(self, x):
        self.calls += 1
        return super().values(x) + (self.calls // 100) * 1e-12


class Local(Sound):
    """Claims a point beside the optimum."""

    optimum_point = HOME + 0.01
    optimum = float(((HOME + 0.01 - HOME) ** 2).sum())


class Unsearched(Sound):
    """Claims a value that no random point has."""

    optimum, optimum_point = 1e-4, None
