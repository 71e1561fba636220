"""BIPOP-CMA-ES: restarts of CMA-ES with large populations and with small ones, at equal budgets."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Generator
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from bench.contract.objective import Objective
from bench.contract.optimizer import parameter
from bench.contract.typing import Floats
from optimizers.cma_es import BoxedCMA, BoxMap
from optimizers.cma_es_fast import Rates, Strategy, rates
from optimizers.common.base import works

TOLFUN = 1e-12
TOLX = 1e-12  # in units of the initial standard deviation of the first run
FREE = 0.1  # the distance from the box, in units of its width, that costs as much as a generation's values differ
CHECKED = 10  # generations between two checks for stagnation, whose medians cost more than a small generation


@dataclass(frozen=True)
class BIPOPCMAES(BoxedCMA):
    """CMA-ES restarted until the budget is spent, in the regime that has spent less of it so far.

    Example:
        >>> bench.solve("signature-12", BIPOPCMAES(), budget=60_000, seed=1).fun

    Source: N. Hansen, Benchmarking a BI-population CMA-ES on the BBOB-2009 function testbed, GECCO workshop, 2009,
    doi:10.1145/1570256.1570333. One regime doubles the population at each of its restarts; the other draws a small
    population and a small step at random. The first run, of the default population, counts as one of the latter, as
    in pycma; the budget replaces the paper's limit of nine doublings.

    Attributes:
        agents: the population size of the first run, at least 6; None is 4 + floor(3 ln d).
        handling: ``"box"`` takes every point to the nearest one of the box, ``"repair"`` then applies the problem's own
            rule; the search goes on from the points before either, with the penalty of :class:`Run`.
        start: the initial mean of the first run; every restart begins at a point of ``objective.initial``.
        sigma: the initial standard deviation of the first run and of the large populations, in units of the box's
            width; the paper's 2 in a box of width 10 is 0.2.
        variant: ``"paper"`` makes each run a :class:`Run`, with the parameters and stop criteria of 2009; on COCO's
            functions its running times are those of the archived runs. ``"pycma"`` makes each a run of ``cma-es-fast``,
            with negative weights and pycma's periodic map into the box: better where variables are periodic or optima
            lie on bounds, as in the signature fit; slower on rotated Rastrigin functions.
    """

    code: ClassVar[str] = "written here after Hansen (2009), on this package's cma-es-fast"
    bibtex: ClassVar[str] = works("hansen2009bipop")
    invariances: ClassVar[tuple[str, ...]] = ("translation", "scale", "monotone", "budget")

    fewest: ClassVar[int] = 6

    agents: int | None = parameter(None, minimum=fewest)
    sigma: float = parameter(0.2, minimum=1e-9, maximum=10.0)
    variant: Literal["paper", "pycma"] = "paper"

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent."""
        follow, bounded = (Run, NearestPoint) if self.variant == "paper" else (Strategy, BoxMap)
        box = bounded(objective.lower, objective.upper)
        plan = restarts(self.population(objective.dimension), rng)
        agents, factor, allowed = next(plan)
        mean = self.mean(objective)
        while True:
            run = follow(box, mean, self.sigma * factor, agents, rng)
            if self.variant == "paper":
                run.tolx = TOLX * self.sigma * float(np.max(objective.upper - objective.lower))
            generations = min(100 + 50 * (objective.dimension + 3) ** 2 / math.sqrt(agents), allowed / agents)
            while not run.stops and run.generation < generations:
                run.tell(self.evaluate(objective, run.ask()))
            agents, factor, allowed = plan.send(run.generation * agents)
            mean = objective.initial(1)[0]


class NearestPoint(BoxMap):
    """The projection on the box."""

    def __call__(self, x: Floats) -> Floats:
        """Return the points of the box nearest to the (n, d) points."""
        return np.minimum(np.maximum(x, self.lower), self.upper)

    def inverse(self, x: Floats) -> Floats:
        """Return the (d,) point of the box itself."""
        return x


class Run(Strategy):
    """One run of CMA-ES with the parameters and the stop criteria of the paper, and a penalty outside the box.

    Beside ``cma-es-fast``, no weight is negative, large populations have the tutorial's damping (eq. 55), and the
    criteria are the paper's, as the tutorial explains them (arXiv:1604.00772, section B.3).

    The paper searches without bounds. Here a point outside is evaluated at the nearest point of the box, and a penalty
    that grows with the square of its distance is added to its value (tutorial, section B.5). A tenth of the box's width
    in one variable costs the interquartile range of the generation's values, so the penalty scales with the values. It
    vanishes beside them once the steps are short, so that an optimum on the bounds is reached exactly.

    A periodic map into the box, as ``cma-es-fast`` and pycma have it, shows the search copies of the function beyond
    the bounds instead of a basin; rotated Rastrigin functions take it longer (docs/explanation/same-algorithms.md has
    the numbers).
    """

    tolfun = TOLFUN
    tolfacupx = math.inf  # pycma's own
    tolxstagnation = (0.0, math.inf, 0.0)  # likewise

    def __init__(self, box: BoxMap, mean: Floats, sigma: float, agents: int, rng: np.random.Generator) -> None:
        super().__init__(box, mean, sigma, agents, rng)
        d = len(mean)
        self._recent = deque(maxlen=10 + math.ceil(30 * d / agents))
        self._ties: deque[bool] = deque(maxlen=3 * (10 + d))

    def parameters(self, d: int, agents: int) -> Rates:
        """Return the weights, none negative, and the learning rates."""
        usual = rates(d, agents)
        cs = (usual.mueff + 2) / (d + usual.mueff + 5)  # (tutorial, eq. 55)
        damps = 1 + 2 * max(0.0, math.sqrt((usual.mueff - 1) / (d + 1)) - 1) + cs
        return usual._replace(weights=np.maximum(usual.weights, 0.0), cs=cs, damps=damps)

    def tell(self, f: Floats) -> None:
        """Learn from the (agents,) values of the last points in the box, and set :attr:`stops`."""
        super().tell(f + self.penalty(f))

    def penalty(self, f: Floats) -> Floats:
        """Return the penalty on the (agents,) values of the last points for their distance from the box."""
        x = self.points
        outside = (x - self.box(x)) / (FREE * (self.box.upper - self.box.lower))
        ordered = np.sort(f[np.isfinite(f)])
        if not outside.any() or not len(ordered):
            return np.zeros(len(f))
        spread = ordered[3 * len(ordered) // 4] - ordered[len(ordered) // 4]
        return np.asarray(spread * (outside**2).sum(axis=1))

    def _tolerances_of_values(self, f: Floats) -> set[str]:
        """Return the tolerances that the sorted values ``f`` meet, together with those of earlier generations."""
        n, d = self.agents, len(self.mean)
        best, worst = float(f[0]), float(f[-1])
        self._recent.append(best)
        self._ties.append(bool(f[0] == f[math.ceil(0.1 + n / 4)]))
        self._bests.append(best)
        self._medians.append(float(f[(n - 1) // 2] + f[n // 2]) / 2)
        past = max(self._recent) - min(self._recent)  # NaN among infinite values, which meets no tolerance
        met = set()
        if past < self.tolfun and worst - best < self.tolfun:
            met.add("tolfun")
        if past < self.tolfun and len(self._recent) == self._recent.maxlen:
            met.add("tolhistfun")
        if sum(self._ties) >= 10 + d:
            met.add("equalfunvals")
        window = min(max(120 + 30 * d / n, self.generation / 5), 20_000)
        if (
            self.generation >= window
            and self.generation % CHECKED == 0
            and all(
                np.median(x[-int(0.3 * window) :]) >= np.median(x[-int(window) : -int(0.7 * window)])
                for x in (self._bests, self._medians)
            )
        ):
            met.add("stagnation")
        return met


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
