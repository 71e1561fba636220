"""BIPOP-CMA-ES: restarts of CMA-ES with large populations and with small ones, at equal budgets."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from bench.objective import Objective
from optimizers.cma_es import BoxMap
from optimizers.cma_es_fast import CMAESFast, Strategy
from optimizers.common.base import works


@dataclass(frozen=True)
class BIPOPCMAES(CMAESFast):
    """CMA-ES restarted until the budget is spent, in the regime that has spent less of it so far.

    Example:
        >>> bench.solve("signature-12", BIPOPCMAES(), budget=60_000, seed=1).fun

    Source: N. Hansen, Benchmarking a BI-population CMA-ES on the BBOB-2009 function testbed, GECCO workshop, 2009,
    doi:10.1145/1570256.1570333. One regime doubles the population at each of its restarts; the other draws a small
    population and a small step at random. The first run, of the default population, counts as one of the latter, as
    in pycma; the budget replaces the paper's limit of nine doublings. Every run is one of ``cma-es-fast``, the CMA-ES
    compiled here, as Python's share of the time is largest in small populations.

    Attributes:
        agents: the population size of the first run, at least 6; None is 4 + floor(3 ln d).
        handling: see :class:`~optimizers.cma_es.BoxedCMA`.
        start: the initial mean of the first run; every restart begins at a point of ``objective.initial``.
        sigma: the initial standard deviation of the first run and of the large populations, in units of the box's
            width; the paper's 2 in a box of width 10 is 0.2.
    """

    code: ClassVar[str] = "written here after Hansen (2009), on this package's cma-es-fast"
    bibtex: ClassVar[str] = works("hansen2009bipop")

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent."""
        box = BoxMap(objective.lower, objective.upper)
        plan = restarts(self.population(objective.dimension), rng)
        agents, factor, allowed = next(plan)
        mean = self.mean(objective)
        while True:
            strategy = Strategy(box, mean, self.sigma * factor, agents, rng)
            generations = min(100 + 50 * (objective.dimension + 3) ** 2 / math.sqrt(agents), allowed / agents)
            while not strategy.stops and strategy.generation < generations:
                strategy.tell(self.evaluate(objective, strategy.ask()))
            agents, factor, allowed = plan.send(strategy.generation * agents)
            mean = objective.initial(1)[0]


def restarts(first: int, rng: np.random.Generator) -> Generator[tuple[int, float, float], int, None]:
    """Yield population, factor of the initial step and allowed evaluations of each run, the first included.

    Each ``send`` takes the number of evaluations that the run spent.

    Args:
        first: the population of the first run.
        rng: draws the small populations and steps.
    """
    small = yield first, 1.0, math.inf
    large = last = 0
    population = first
    while True:
        if small < large:
            u, v = rng.random(2)
            drawn = int(first * (0.5 * population / first) ** (u * u))
            small += yield drawn, 10 ** (-2 * v), last / 2
        else:
            population *= 2
            last = yield population, 1.0, math.inf
            large += last
