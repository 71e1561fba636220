"""Base class of the CMA-ES optimizers: their parameters, and the map from an unbounded space into the box."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from bench.objective import Objective
from bench.optimizer import Optimizer, parameter
from bench.problem import Floats
from optimizers.common.compiled import compiled


@dataclass(frozen=True)
class BoxedCMA(Optimizer):
    """A CMA-ES that searches an unbounded space, from which a map takes its points into the box.

    Attributes:
        agents: the population size lambda; None is pycma's 4 + floor(3 ln d). The thesis uses 300.
        handling: ``"box"`` maps the points into the box alone, as in the thesis; ``"repair"`` then applies the
            problem's own rule before evaluation; the search goes on from the points before this repair.
        start: the initial mean: ``"random"``, a point of ``objective.initial``, or ``"midpoint"`` of the box, as in
            section 7.1.1 of the thesis.
        sigma: the initial standard deviation in units of the box's width; 1/4 in section 7.1.1.
    """

    fewest: ClassVar[int] = 4  # agents

    agents: int | None = parameter(None, minimum=fewest)
    handling: Literal["repair", "box"] = "repair"
    start: Literal["random", "midpoint"] = "random"
    sigma: float = parameter(0.25, minimum=1e-9, maximum=10.0)

    def population(self, dimension: int) -> int:
        """Return lambda for ``dimension`` variables: ``agents``, or Hansen, arXiv:1604.00772, eq. 48."""
        return self.agents if self.agents is not None else max(self.fewest, 4 + int(3 * np.log(dimension)))

    def mean(self, objective: Objective) -> Floats:
        """Return the (d,) point of the box where the search starts."""
        if self.start == "midpoint":
            return np.asarray((objective.lower + objective.upper) / 2)
        return np.asarray(objective.initial(1)[0])

    def evaluate(self, objective: Objective, x: Floats) -> Floats:
        """Return the (n,) values of the (n, d) points ``x`` of the box, first repaired if ``handling`` says so."""
        return np.asarray(objective(objective.repair(x) if self.handling == "repair" else x))


class BoxMap:
    """The map of pycma's option ``bounds``: periodic, quadratic near the bounds, the identity between.

    Args:
        lower: (d,) lower ends of the box.
        upper: (d,) upper ends of the box.
    """

    def __init__(self, lower: Floats, upper: Floats) -> None:
        half = (upper - lower) / 2
        self.lower, self.upper = lower, upper
        self.below = np.minimum(half, np.maximum(1, np.abs(lower)) / 20)  # width of the quadratic ends
        self.above = np.minimum(half, np.maximum(1, np.abs(upper)) / 20)  # (pycma: margin_width2)

    def __call__(self, x: Floats) -> Floats:
        """Return the (n, d) unbounded points mapped into the box (pycma: BoxConstraintsLinQuadTransformation)."""
        return _to_box(x, self.lower, self.upper, self.below, self.above)

    def inverse(self, x: Floats) -> Floats:
        """Return a pre-image of the (d,) point ``x`` of the box."""
        lower, upper, below, above = self.lower, self.upper, self.below, self.above
        y = np.where(x < lower + below, lower - below + 2 * np.sqrt(below * np.maximum(x - lower, 0.0)), x)
        return np.where(x > upper - above, upper + above - 2 * np.sqrt(above * np.maximum(upper - x, 0.0)), y)


@compiled
def _to_box(x: Floats, lower: Floats, upper: Floats, below: Floats, above: Floats) -> Floats:
    """Shift by whole periods, mirror at the outer ends, bend quadratically near the bounds; the identity between."""
    mapped = np.empty_like(x)
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            y, width = x[i, j], upper[j] - lower[j]
            start = lower[j] - 2 * below[j] - width / 2.0
            if y < start or y > upper[j] + 2 * above[j] + width / 2.0:
                period = 2 * (upper[j] - lower[j] + below[j] + above[j])
                y -= period * ((y - start) // period)
            if y > upper[j] + above[j]:
                y -= 2 * (y - upper[j] - above[j])
            if y < lower[j] - below[j]:
                y += 2 * (lower[j] - below[j] - y)
            if y < lower[j] + below[j]:
                y = lower[j] + (y - (lower[j] - below[j])) ** 2 / 4 / below[j]
            if y > upper[j] - above[j]:
                y = upper[j] - (y - (upper[j] + above[j])) ** 2 / 4 / above[j]
            mapped[i, j] = min(max(y, lower[j]), upper[j])  # rounding alone can leave the box
    return mapped
