"""Problems for the diagnosis of biases: classic functions, and noise on which no place is better than another."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bench.problem import Floats, FunctionProblem

SHIFT = 0.1  # of the box, in every variable
HALF_WIDTH = 100.0  # of the functions' box [-100, 100]

Function = Callable[[Floats], Floats]


class RecordingProblem(FunctionProblem):
    """A problem on [lower, upper]^d that records the points of one run."""

    def __init__(self, function: Function, lower: float, upper: float, dimension: int, name: str) -> None:
        super().__init__(function, [lower] * dimension, [upper] * dimension, name=name)
        self._batches: list[Floats] = []

    def evaluate(self, x: Floats) -> Floats:
        """Return the (n,) values of the (n, d) points ``x``."""
        self._batches.append(x)
        return super().evaluate(x)

    @property
    def points(self) -> Floats:
        """All points so far, (n, d), in the order of their evaluation."""
        return np.concatenate(self._batches)

    def share(self, x: Floats) -> Floats:
        """Return points as shares of the box, 0 at the lower and 1 at the upper bounds."""
        return np.asarray((x - self.lower) / (self.upper - self.lower))


def function(name: str, dimension: int, *, moved: bool) -> RecordingProblem:
    """Return one of ``FUNCTIONS`` with its optimum, 0, at the centre of the box or moved by ``SHIFT``."""
    shift = SHIFT * 2 * HALF_WIDTH if moved else 0.0
    return RecordingProblem(lambda x: FUNCTIONS[name](x - shift), -HALF_WIDTH, HALF_WIDTH, dimension, name)


def noise(box: tuple[float, float], dimension: int, seed: int) -> RecordingProblem:
    """Return pure noise on a box: the k-th evaluation of a run has the k-th uniform number of the seed's stream.

    No point is better than another, so only the optimizer's own rules decide where its best point lies (the function
    f0 of Kononova et al., Information Sciences 298, 2015, doi:10.1016/j.ins.2014.11.035).
    """
    rng = np.random.default_rng(seed)
    return RecordingProblem(lambda x: rng.random(len(x)), *box, dimension, "noise")


def _sphere(z: Floats) -> Floats:
    return np.asarray((z**2).sum(axis=1))


def _ellipsoid(z: Floats) -> Floats:
    weights = 10 ** np.linspace(0, 6, z.shape[1])
    return np.asarray((weights * z**2).sum(axis=1))


def _rastrigin(z: Floats) -> Floats:
    y = z * 0.0512
    return np.asarray((y**2 - 10 * np.cos(2 * np.pi * y) + 10).sum(axis=1))


def _ackley(z: Floats) -> Floats:
    y = z * 0.32
    radius = np.sqrt((y**2).mean(axis=1))
    waves = np.cos(2 * np.pi * y).mean(axis=1)
    return np.asarray(20 - 20 * np.exp(-0.2 * radius) + np.e - np.exp(waves))


def _griewank(z: Floats) -> Floats:
    y = z * 6.0
    return np.asarray((y**2).sum(axis=1) / 4000 - np.cos(y / np.sqrt(np.arange(1, z.shape[1] + 1))).prod(axis=1) + 1)


# The classic unimodal and multimodal functions, each on its usual domain scaled to the box; all are 0 at the origin.
FUNCTIONS: dict[str, Function] = {
    "sphere": _sphere, "ellipsoid": _ellipsoid, "Rastrigin": _rastrigin, "Ackley": _ackley, "Griewank": _griewank,
}  # fmt: skip
