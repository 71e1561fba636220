"""A family of problems that anybody can install beside backlash-bench: water-filling-2, -4 and -8.

A transmitter shares its power between n parallel Gaussian channels of unequal noise so that their capacity is largest
(Boyd and Vandenberghe 2004, Convex Optimization, example 5.2):

    minimise  -sum_i log2(1 + p_i / noise_i)   where   p_i >= 0,   sum_i p_i <= total
"""

import numpy as np

from bench import BenchError, Problem

SIZES = (2, 4, 8)


class WaterFilling(Problem):
    """Minimise the negative capacity (bits per use) of ``n`` channels over their powers, limited to ``total``."""

    def __init__(self, name: str, n: int, total: float) -> None:
        self.name = name
        self.variables = tuple(f"p{i + 1}" for i in range(n))
        self.lower, self.upper = np.zeros(n), np.full(n, total)
        self.total = total
        self.noise = np.linspace(0.1, 1.0, n)
        best = spend(-self.noise[None], total)  # water to one level over the noise, eq. (5.39) there
        self.optimum, self.optimum_point = float(self.evaluate(best)[0]), best[0]

    def evaluate(self, x: np.ndarray) -> np.ndarray:
        """Return the (n,) objective values of (n, d) powers; powers beyond the total are worth nothing."""
        values = -np.log2(1 + x / self.noise).sum(axis=1)
        return np.where(x.sum(axis=1) <= self.total * (1 + 1e-12), values, np.inf)

    def repair(self, x: np.ndarray) -> np.ndarray:
        """Return the feasible (n, d) powers nearest to ``x``: within the box, and no more than the total is spent."""
        clipped = super().repair(x)
        return np.where(clipped.sum(axis=1, keepdims=True) <= self.total, clipped, spend(x, self.total))

    def describe(self, x: np.ndarray) -> dict[str, float]:
        """Return the capacity in bits per use, and the number of channels that the (d,) powers ``x`` use."""
        return {"capacity_bits": -float(self.evaluate(x[None])[0]), "channels": float((x > 1e-3 * self.total).sum())}


def spend(x: np.ndarray, total: float) -> np.ndarray:
    """Return the points nearest to the (n, d) ``x`` that are not negative and sum to ``total`` (Duchi et al. 2008)."""
    descending = -np.sort(-x, axis=1)
    levels = (descending.cumsum(axis=1) - total) / np.arange(1, x.shape[1] + 1)
    positive = (descending > levels).sum(axis=1, keepdims=True)
    return np.maximum(x - np.take_along_axis(levels, positive - 1, axis=1), 0.0)


class Family:
    """What the entry point names: the names that can be listed, and the problem behind each."""

    def names(self) -> list[str]:
        """Return the names of all members."""
        return [f"water-filling-{n}" for n in SIZES]

    def load(self, name: str, /, *, total: float = 1.0) -> WaterFilling:
        """Return the problem of that name; raises BenchError where the name or the total power is wrong."""
        if name not in self.names():
            raise BenchError(f"unknown problem {name!r}; there are {', '.join(self.names())}")
        if not 0 < total < np.inf:
            raise BenchError(f"problem {name!r}: the total power must be a positive number, not {total!r}")
        return WaterFilling(name, int(name.rpartition("-")[2]), float(total))


family = Family()
