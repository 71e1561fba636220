"""The problems on which optimizers are checked: each is demanding for one rule of the contract, or shows a bias."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from bench.contract.problem import FunctionProblem
from bench.contract.typing import Floats

# The ordinary box, uneven and without the origin, and the place of the optimum as a share of its widths; they are
# repeated up to the number of variables.
_LOWER, _UPPER, _BEST = (-2.0, 10.0, -1000.0), (5.0, 10.5, -10.0), (0.3, 0.65, 0.8)

SHIFT = 0.1  # of the box, in every variable
HALF_WIDTH = 100.0  # of the classic functions' box [-100, 100]


class RecordingProblem(FunctionProblem):
    """A problem that records the points of one run."""

    def __init__(self, *arguments: Any, **naming: Any) -> None:
        super().__init__(*arguments, vectorized=True, **naming)
        self._batches = [np.empty((0, self.dimension))]

    def evaluate(self, x: Floats, rng: np.random.Generator | None = None) -> Floats:
        """Return the (n,) values of the (n, d) points ``x``."""
        self._batches.append(x.copy())
        return super().evaluate(x, rng)

    @property
    def points(self) -> Floats:
        """All points so far, (n, d), in the order of their evaluation."""
        return np.concatenate(self._batches)

    @property
    def first_batch(self) -> int:
        """The number of points that were evaluated first, together."""
        return len(self._batches[1]) if len(self._batches) > 1 else 0

    def share(self, x: Floats) -> Floats:
        """Return points as shares of the box, 0 at the lower and 1 at the upper bounds."""
        return np.asarray((x - self.lower) / (self.upper - self.lower))


def bowl(dimension: int = 3, **naming: object) -> RecordingProblem:
    """Return the ordinary problem: a paraboloid whose optimum is neither at the centre nor on the diagonal."""
    return _ordinary(lambda _, f: f, dimension, **naming)


def spiked(best: Floats) -> RecordingProblem:
    """Return the ordinary problem but for one point, a share of the box, whose value is far below all others."""
    return _ordinary(lambda u, f: np.where((u == best).all(axis=1), -1e9, f), len(best))


def corner() -> RecordingProblem:
    """Return a plane that falls towards a corner of a box of widths 1e-3, 1e-6 and 4.9e4 far from the origin."""
    lower, upper = np.array([100.0, 1e-3, -5e4]), np.array([100.001, 1.001e-3, -1e3])
    slope = np.array([1.0, -1.0, 1.0])
    return RecordingProblem(lambda x: ((x - lower) / (upper - lower)) @ slope, lower, upper, name="corner")


def odd() -> dict[str, RecordingProblem]:
    """Return problems with values that are rare but allowed, by their description."""
    kinds: dict[str, Callable[[Floats, Floats], Floats]] = {
        "equal values": lambda _, f: np.zeros_like(f),
        "+inf everywhere": lambda _, f: np.full_like(f, np.inf),
        "+inf and NaN in half of the box": lambda u, f: np.select([u[:, 0] > 0.75, u[:, 0] > 0.5], [np.nan, np.inf], f),
        "values of 1e300": lambda _, f: f * 1e300,
        "values of 1e-300": lambda _, f: f * 1e-300,
        "negative values": lambda _, f: f - 1e6,
    }
    return {name: _ordinary(values, 3, name=name) for name, values in kinds.items()}


def _ordinary(values: Callable[[Floats, Floats], Floats], dimension: int, **naming: object) -> RecordingProblem:
    """Return a problem of the shares ``u`` of the box and the paraboloid's values ``f`` in the ordinary box."""
    lower, upper, best = (np.resize(shares, dimension) for shares in (_LOWER, _UPPER, _BEST))

    def evaluate(x: Floats) -> Floats:
        u = (x - lower) / (upper - lower)
        return values(u, ((u - best) ** 2).sum(axis=1))

    return RecordingProblem(evaluate, lower, upper, **naming)


def classic(name: str, dimension: int, *, moved: bool) -> RecordingProblem:
    """Return one of ``FUNCTIONS`` with its optimum, 0, at the centre of the box or moved by ``SHIFT``."""
    shift, bounds = SHIFT * 2 * HALF_WIDTH if moved else 0.0, np.full(dimension, HALF_WIDTH)
    function, scale = FUNCTIONS[name]
    return RecordingProblem(lambda x: function((x - shift) * scale), -bounds, bounds, name=name)


def noise(box: tuple[float, float], dimension: int, seed: int) -> RecordingProblem:
    """Return pure noise on a box: the k-th evaluation of a run has the k-th uniform number of the seed's stream.

    No point is better than another, so only the optimizer's own rules decide where its best point lies (the function
    f0 of Kononova et al., Information Sciences 298, 2015, doi:10.1016/j.ins.2014.11.035).
    """
    rng = np.random.default_rng(seed)
    return RecordingProblem(lambda x: rng.random(len(x)), *np.repeat([box], dimension, axis=0).T, name="noise")


def _ackley(y: Floats) -> Floats:
    radius, waves = np.sqrt((y**2).mean(axis=1)), np.cos(2 * np.pi * y).mean(axis=1)
    return np.asarray(20 - 20 * np.exp(-0.2 * radius) + np.e - np.exp(waves))


def _griewank(y: Floats) -> Floats:
    return np.asarray((y**2).sum(axis=1) / 4000 - np.cos(y / np.sqrt(np.arange(1, y.shape[1] + 1))).prod(axis=1) + 1)


FUNCTIONS: dict[str, tuple[Callable[[Floats], Floats], float]] = {
    "sphere": (lambda y: (y**2).sum(axis=1), 1.0),
    "ellipsoid": (lambda y: (10 ** np.linspace(0, 6, y.shape[1]) * y**2).sum(axis=1), 1.0),
    "Rastrigin": (lambda y: (y**2 - 10 * np.cos(2 * np.pi * y) + 10).sum(axis=1), 0.0512),
    "Ackley": (_ackley, 0.32),
    "Griewank": (_griewank, 6.0),
}
"""Classic unimodal and multimodal functions with their optimum, 0, at the origin, and the scale that maps the box to
the usual domain of each."""
