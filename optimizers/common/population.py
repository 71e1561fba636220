"""Base class of the population methods, and the handling of points outside the feasible region."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from bench.objective import Objective
from bench.optimizer import Optimizer, parameter
from bench.problem import Floats

Handling = Literal["repair", "box"]


def confine(objective: Objective, x: Floats, handling: Handling) -> Floats:
    """Return the (n, d) points ``x`` clipped to the box and, unless ``handling`` is ``"box"``, repaired."""
    x = np.minimum(np.maximum(x, objective.lower), objective.upper)
    return np.ascontiguousarray(objective.repair(x)) if handling == "repair" else x


@dataclass(frozen=True)
class Population(Optimizer):
    """A method that moves a population of ``agents`` and evaluates all of it once a generation.

    Attributes:
        agents: N, the population size; 30 is what the authors of the swarms here use (the thesis uses 300).
        handling: how agents return to the feasible region once all of them have moved. ``"repair"`` clips them to the
            box and then applies the problem's own rule; ``"box"`` only clips them. The resulting points are evaluated,
            and the algorithm goes on from them. The start population is repaired in both cases.
    """

    agents: int = parameter(30, minimum=1)
    handling: Handling = "repair"

    def generations(self, objective: Objective) -> int:
        """Return T = ceil(budget / N), the number of generations; the objective cuts the last one short."""
        return -(-objective.budget // self.agents)

    def confine(self, objective: Objective, x: Floats) -> Floats:
        """Return the (n, d) points ``x`` clipped to the box and, unless ``handling`` is ``"box"``, repaired."""
        return confine(objective, x, self.handling)
