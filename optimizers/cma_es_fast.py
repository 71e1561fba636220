"""CMA-ES compiled: pycma's algorithm and defaults, in loops that numba compiles."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from bench.contract.objective import Objective
from bench.contract.optimizer import parameter
from bench.contract.typing import Floats
from optimizers.cma_es import BoxedCMA, BoxMap
from optimizers.common.base import compiled, works

TOLFUN, TOLFUNHIST, TOLX, TOLFACUPX, TOLUPSIGMA, TOLCONDITIONCOV = 1e-11, 1e-12, 1e-11, 1e3, 1e20, 1e14
TOLXSTAGNATION = (1e-9, 20, 0.1)  # distance, generations, share of the generations so far
COORDINATES_CONDITION, AXES_CONDITION = 1e8, 1e12  # beyond these C is rewritten in better coordinates
LARGE_SIGMA = 1e9  # beyond this, half of sigma's growth goes over to C
"""pycma's defaults, under pycma's names where it has one."""


@dataclass(frozen=True)
class CMAESFast(BoxedCMA):
    """The covariance matrix adaptation evolution strategy of ``cma-es``, many times faster.

    Example:
        >>> bench.solve("signature-12", CMAESFast(agents=300, handling="box", start="midpoint"), budget=60_000).fun

    Source: the thesis, eqs. 6.1 to 6.6, with the negative weights and the parameters of N. Hansen, The CMA Evolution
    Strategy: A Tutorial, arXiv:1604.00772, eqs. 48 to 58. Where pycma 4.5 goes beyond the tutorial (damping at large
    populations, limits of the standard deviations, coordinates for ill-conditioned problems, stopping tolerances),
    this follows pycma: from the same draws both evaluate the same points up to rounding, so that their results agree
    in distribution, not bit by bit. pycma's mirrored samples, which it uses below six agents, and its other step-size
    rule from 300 variables on are left out. Eigenvectors come from numpy's LAPACK: another LAPACK moves last digits.

    Attributes:
        agents: as in :class:`~optimizers.cma_es.BoxedCMA`, at least 6.
        handling, start, sigma: see :class:`~optimizers.cma_es.BoxedCMA`.
        active: whether the worse half of a generation has negative weights, as in :class:`~optimizers.cma_es.CMAES`.
    """

    code: ClassVar[str] = "written here after the thesis's eqs. 6.1-6.6 and Hansen's tutorial"
    bibtex: ClassVar[str] = works("hansen2001", "hansen2016")

    fewest: ClassVar[int] = 6

    agents: int | None = parameter(None, minimum=fewest)
    active: bool = True

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent or a tolerance is met."""
        box = BoxMap(objective.lower, objective.upper)
        agents = self.population(objective.dimension)
        strategy = Strategy(box, self.mean(objective), self.sigma, agents, rng, active=self.active)
        while not strategy.stops:
            strategy.tell(self.evaluate(objective, strategy.ask()))
        objective.stop(" ".join(sorted(strategy.stops)))


class Rates(NamedTuple):
    """The strategy parameters that depend on the dimension and the population size alone; ``weights`` is (agents,)."""

    weights: Floats
    mueff: float
    cs: float
    damps: float
    cc: float
    c1: float
    cmu: float
    chi: float


def rates(d: int, agents: int) -> Rates:
    """Return the weights and the learning rates (equation numbers: Hansen, arXiv:1604.00772)."""
    raw = math.log((agents + 1) / 2) - np.log(np.arange(1, agents + 1))  # (eq. 49)
    mu = agents // 2
    positive, negative = raw[:mu].sum(), np.abs(raw[mu:]).sum()
    mueff = positive**2 / (raw[:mu] ** 2).sum()
    mueff_minus = negative**2 / (raw[mu:] ** 2).sum()
    c1 = 2 / ((d + 1.3) ** 2 + mueff)  # (eq. 57)
    cmu = min(1 - c1, 2 * (0.25 + mueff + 1 / mueff - 2) / ((d + 2) ** 2 + mueff))  # (eq. 58)
    share = min(1 + c1 / cmu, 1 + 2 * mueff_minus / (mueff + 2), (1 - c1 - cmu) / (d * cmu))  # (eqs. 50 to 52)
    weights = raw * np.where(raw > 0, 1 / positive, share / negative)  # (eq. 53)
    cs = min(0.5, (mueff + 2) / (d + mueff + 3))  # pycma; the tutorial's eq. 55 has d + mueff + 5
    wide = max(1.0, 3 * (1 - 0.5 ** (d / 9)))  # pycma 4.5: large populations are damped more; eq. 55 has 1
    damps = 1 + 2 * max(0.0, wide * math.sqrt((mueff - 1) / (d + 1)) - 1) + cs  # (eq. 55)
    cc = (4 + mueff / d) / (d + 4 + 2 * mueff / d)  # (eq. 56)
    chi = math.sqrt(2) * math.exp(math.lgamma((d + 1) / 2) - math.lgamma(d / 2))  # (in the thesis's eq. 6.4)
    return Rates(weights, float(mueff), float(cs), float(damps), float(cc), float(c1), float(cmu), chi)


class Strategy:
    """One run of CMA-ES: :meth:`ask` returns points of the box, :meth:`tell` takes their values.

    Args:
        box: where the points lie.
        mean: (d,) the point of the box around which the first ones are drawn.
        sigma: the initial standard deviation in units of the box's width.
        agents: the population size, at least 6.
        rng: the only source of random numbers.
        active: whether the worse half of the points has negative weights.
    """

    tolfun: float = TOLFUN
    tolx: float = TOLX
    tolfacupx: float = TOLFACUPX
    tolxstagnation: tuple[float, float, float] = TOLXSTAGNATION

    def __init__(
        self, box: BoxMap, mean: Floats, sigma: float, agents: int, rng: np.random.Generator, active: bool = True
    ) -> None:
        d = len(mean)
        self.box, self.agents, self.rng, self.active = box, agents, rng, active
        self.rates = self.parameters(d, agents)
        self.limit = (box.upper - box.lower) * (1 / 3)  # of the standard deviations (pycma: maxstd)
        self.first_scale = sigma * (box.upper - box.lower)
        self.scale = self.first_scale.copy()  # by coordinate; a point is mean + sigma * scale * N(0, C)
        self.sigma, self.mean = 1.0, box.inverse(mean)
        self.pc, self.ps = np.zeros(d), np.zeros(d)
        self.coordinates: Floats | None = None  # (d, d), maps the search's own coordinates to the unbounded space
        self.gap = 1 / (self.rates.c1 + self.rates.cmu) / d / 10  # generations between decompositions
        self.generation = self.decomposed = 0
        self._whiten()
        self.stops: set[str] = set()
        self._recent: deque[float] = deque(maxlen=10 + int(30 * d / agents))
        self._bests: list[float] = []  # of every fifth generation, as are the medians
        self._medians: list[float] = []
        self._best, self._best_at = np.inf, 0
        self._anchor, self._anchored = self.mean, 0
        self._flat = 0
        self._tolupsigma = TOLUPSIGMA

    def parameters(self, d: int, agents: int) -> Rates:
        """Return the weights and the learning rates in ``d`` variables."""
        usual = rates(d, agents)
        return usual if self.active else usual._replace(weights=np.maximum(usual.weights, 0.0))

    def ask(self) -> Floats:
        """Return (agents, d) points of the box to evaluate."""
        variances = np.diag(self.C)
        if variances.max() >= COORDINATES_CONDITION * variances.min():
            self._scale_coordinates()
        if self.coordinates is None and self.D[-1] ** 2 >= AXES_CONDITION * self.D[0] ** 2:
            self._change_coordinates()
        if self.generation >= self.decomposed + self.gap:
            self._decompose()
            self.decomposed = self.generation
        z = self.rng.standard_normal((self.agents, len(self.mean)))
        self._points = sample(z, self.mean, self.sigma, self.scale, self.B, self.D)
        return self.box(self.points)

    @property
    def points(self) -> Floats:
        """The last (agents, d) points in the unbounded space, before the map into the box."""
        return self._points if self.coordinates is None else self._points @ self.coordinates.T

    def tell(self, f: Floats) -> None:
        """Learn from the (agents,) values of the last points, and set :attr:`stops`."""
        self.generation += 1
        order = np.argsort(f)
        self.mean, self.sigma = learn(
            self._points[order], self.rates, self.generation, self.mean, self.sigma,
            self.scale, self.C, self.B, self.D, self.pc, self.ps, self.limit,
        )  # fmt: skip
        largest = float(np.diag(self.C).max())
        if self.sigma > LARGE_SIGMA and self.sigma > math.sqrt(largest):
            factor = self.sigma / math.sqrt(largest)
            self.C *= factor
            self.D *= math.sqrt(factor)
            self.sigma /= math.sqrt(factor)
            self._tolupsigma /= math.sqrt(factor)
        self.stops = self._tolerances_of_values(f[order]) | self._tolerances_of_the_distribution()

    def _whiten(self) -> None:
        """Start with C nearly I; its eigenvalues differ, so that they have an order on every machine."""
        d = len(self.mean)
        variances = np.exp(1e-4 / d * np.arange(d))
        self.C, self.B, self.D = np.diag(variances), np.eye(d), np.sqrt(variances)

    def _decompose(self) -> None:
        """Set B and D, C = B D^2 B', with D increasing; rounding may not make C indefinite."""
        eigenvalues, self.B = np.linalg.eigh(self.C)
        while eigenvalues[0] <= 0:
            self.C[np.diag_indices_from(self.C)] += self.D[0] ** 2
            self.D = np.sqrt(self.D**2 + self.D[0] ** 2)
            eigenvalues, self.B = np.linalg.eigh(self.C)
        self.D = np.sqrt(eigenvalues)

    def _scale_coordinates(self) -> None:
        """Move the variances from C to the scales, which have no limit of precision."""
        factors = np.sqrt(np.diag(self.C))
        self.C /= np.outer(factors, factors)
        self.scale *= factors
        self.pc /= factors
        self._decompose()

    def _change_coordinates(self) -> None:
        """Go on in coordinates where C is the identity; done once."""
        root, inverse = self.B * self.D @ self.B.T, self.B / self.D @ self.B.T
        self.coordinates = self.scale[:, np.newaxis] * root
        self.mean, self.pc = inverse / self.scale @ self.mean, inverse @ self.pc
        self.scale = np.ones_like(self.scale)
        self._whiten()

    def _tolerances_of_values(self, f: Floats) -> set[str]:
        """Return the tolerances that the sorted values ``f`` meet, together with those of earlier generations."""
        n, d = self.agents, len(self.mean)
        best, worst = float(f[0]), float(f[-1])
        if best < self._best:
            self._best, self._best_at = best, self.generation
        self._recent.append(best)
        if self.generation % 5 == 0:
            self._bests.append(best)
            self._medians.append(float(f[(n - 1) // 2] + f[n // 2]) / 2)
        self._flat = 0 if f[0] < f[int(0.75 * n)] else self._flat + 1
        past = max(self._recent) - min(self._recent)  # NaN among infinite values, which meets no tolerance
        met = set()
        if worst - best < self.tolfun and past < self.tolfun:
            met.add("tolfun")
        if len(self._recent) > 9 and past < TOLFUNHIST:
            met.add("tolfunhist")
        if self._flat > 1:
            met.add("tolflatfitness")
        patience = int(100 + 100 * d**1.5 / n)
        window = int(max(patience / 10, len(self._bests) / 10))
        if (
            len(self._bests) > max(100, 2 * window)
            and self.generation > d * (5 + 100 / n)
            and self.generation - self._best_at >= patience / 2
            and all(np.median(x[-window:]) >= np.median(x[-2 * window : -window]) for x in (self._medians, self._bests))
        ):
            met.add("tolstagnation")
        return met

    def _tolerances_of_the_distribution(self) -> set[str]:
        """Return the tolerances that the mean and the covariance matrix meet."""
        least, generations, share = self.tolxstagnation
        allowed = generations + share * self.generation
        waited = self.generation - self._anchored
        grown, small, coordinate, axis, moved = measure(
            self.generation, self.mean, self.sigma, self.scale, self.C, self.B, self.D, self.pc, self.first_scale,
            self._anchor,
        )  # fmt: skip
        if moved > least * math.sqrt(max(1.0, waited / allowed)):
            self._anchor, self._anchored, waited = self.mean, self.generation, 0
        met = {
            "tolfacupx": grown > self.tolfacupx,
            "tolx": small < self.tolx,
            "tolxstagnation": waited > allowed,
            "tolupsigma": self.sigma / self.D[-1] > self._tolupsigma,
            "noeffectcoord": coordinate,
            "noeffectaxis": axis,
            "tolconditioncov": self.D[-1] > math.sqrt(TOLCONDITIONCOV) * self.D[0],
        }
        return {name for name, stopped in met.items() if stopped}


@compiled
def sample(z: Floats, mean: Floats, sigma: float, scale: Floats, B: Floats, D: Floats) -> Floats:
    """Return (lambda, d) points from N(mean, sigma^2 C) in the scaled coordinates, computed from the normal ``z``."""
    n, d = z.shape
    x = np.empty((n, d))
    axes = B * D
    for i in range(n):
        for j in range(d):
            y = 0.0
            for k in range(d):
                y += axes[j, k] * z[i, k]
            x[i, j] = mean[j] + sigma * scale[j] * y  # (eq. 6.1)
    return x


@compiled
def learn(
    x: Floats, rates: Rates, generation: int, old: Floats, sigma: float,
    scale: Floats, C: Floats, B: Floats, D: Floats, pc: Floats, ps: Floats, limit: Floats,
) -> tuple[Floats, float]:  # fmt: skip
    """Return the next mean and sigma from the points ``x``, the best first (thesis, eqs. 6.2 to 6.6).

    ``C``, ``pc``, ``ps`` and ``scale`` change in place. Beside the thesis, C has negative weights for the worse half
    (eqs. 46 and 47 of Hansen's tutorial) and a learning rate for each of its two updates.
    """
    n, d = x.shape
    weights = rates.weights
    mean = np.zeros(d)
    for i in range(n // 2):
        mean += weights[i] * x[i]  # (eq. 6.2)

    step = (mean - old) / (sigma * scale) * math.sqrt(rates.mueff)
    ps *= 1 - rates.cs
    ps += math.sqrt(rates.cs * (2 - rates.cs)) * (B @ ((B.T @ step) / D))  # (eq. 6.3)
    length = (ps**2).sum()
    going = length / (1 - (1 - rates.cs) ** (2 * generation)) / d < 2 + 4 / (d + 1)  # h_sigma
    pc *= 1 - rates.cc
    if going:
        pc += math.sqrt(rates.cc * (2 - rates.cc)) * step  # (eq. 6.5)

    loss = 0.0 if going else rates.cc * (2 - rates.cc)  # (delta of h_sigma, in eq. 6.6)
    C *= 1 - rates.c1 * (1 - loss) - rates.cmu * weights.sum()
    C += rates.c1 * np.outer(pc, pc)
    y, white = np.empty(d), np.empty(d)
    for i in range(n):
        weight = rates.cmu * weights[i]
        y[:] = (x[i] - old) / (sigma * scale)
        if weight < 0:  # the length of a vector with a negative weight is scaled so that C stays positive
            norm = 0.0
            for k in range(d):
                white[k] = 0.0
                for j in range(d):
                    white[k] += B[j, k] * y[j]
                norm += (white[k] / D[k]) ** 2
            weight *= d / (math.sqrt(norm) + 1e-9) ** 2  # (tutorial, eq. 46)
        for j in range(d):
            for k in range(j + 1):
                C[j, k] += weight * y[j] * y[k]  # (eq. 6.6; tutorial, eq. 47)
    for j in range(d):
        for k in range(j):
            C[k, j] = C[j, k]

    change = rates.cs / rates.damps * (math.sqrt(length) / rates.chi - 1)
    sigma *= math.exp(min(max(change, -1.0), 1.0))  # (eq. 6.4)
    slack = math.exp(1e-4) if generation <= 2 else 1.0  # as the eigenvalues differ at the start
    for j in range(d):
        deviation = sigma * scale[j] * math.sqrt(C[j, j])
        if deviation > limit[j] * slack:
            scale[j] *= limit[j] / deviation
    return mean, sigma


@compiled
def measure(
    generation: int, mean: Floats, sigma: float, scale: Floats, C: Floats, B: Floats, D: Floats, pc: Floats,
    first: Floats, anchor: Floats,
) -> tuple[float, float, bool, bool, float]:  # fmt: skip
    """Return the quantities that the tolerances of the distribution limit.

    These are the largest growth of a standard deviation; the largest step; whether a fifth of a standard deviation
    vanishes when it is added to the mean in any coordinate; whether a tenth of one does along an axis; and the
    distance that the mean has moved.
    """
    d = len(mean)
    grown, small, moved, coordinate, axis, i = 0.0, 0.0, 0.0, False, True, generation % d
    for j in range(d):
        deviation = sigma * scale[j] * math.sqrt(C[j, j])
        grown = max(grown, deviation / first[j])
        small = max(small, deviation, sigma * scale[j] * pc[j])
        coordinate |= mean[j] == mean[j] + 0.2 * deviation
        axis &= mean[j] == mean[j] + 0.1 * sigma * D[i] * scale[j] * B[j, i]
        moved += (mean[j] - anchor[j]) ** 2
    return grown, small, coordinate, axis, math.sqrt(moved)
