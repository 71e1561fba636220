"""Uniform random search, the baseline for every other method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from bench.contract.objective import Objective
from optimizers.common.base import Population, works


@dataclass(frozen=True)
class RandomSearch(Population):
    """Independent points, uniform in the box.

    Example:
        >>> bench.solve("signature-12", RandomSearch(), budget=60_000, seed=1).fun

    Source: S. H. Brooks, A discussion of random methods for seeking maxima, Operations Research 6(2), 1958,
    doi:10.1287/opre.6.2.244. With ``handling="repair"`` the points follow the uniform law after the problem's
    repair, the law of every other method's start.

    Attributes:
        agents: the number of points evaluated at once, which changes the speed and not the law.
        handling: see :class:`~optimizers.common.base.Population`.
    """

    bibtex: ClassVar[str] = works("brooks1958")
    code: ClassVar[str] = "written here"
    invariances: ClassVar[tuple[str, ...]] = ("translation", "scale", "monotone", "budget")

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent."""
        span = objective.upper - objective.lower
        x = objective.initial(self.agents)
        for _ in range(self.generations(objective)):
            objective(x)
            x = self.confine(objective, objective.lower + span * rng.random(x.shape))
