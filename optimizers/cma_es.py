"""CMA-ES as the ``cma`` package (pycma) runs it, and the parameters and map into the box that all CMA-ES share."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from bench.contract.objective import Objective
from bench.contract.optimizer import Optimizer, parameter
from bench.contract.typing import Floats
from optimizers.common.base import compiled, works

UNLIMITED: dict[str, object] = {"maxiter": np.inf, "maxfevals": np.inf}
"""Options that switch pycma's limits on length off: the budget ends a trial, or a tolerance of pycma does."""

SILENT: dict[str, object] = {"verbose": -9, "verb_log": 0, "verb_disp": 0, "signals_filename": None}


@dataclass(frozen=True)
class BoxedCMA(Optimizer):
    """A CMA-ES that searches an unbounded space, from which a map takes its points into the box.

    Attributes:
        agents: the population size lambda; None is pycma's 4 + floor(3 ln d). The thesis uses 300.
        handling: ``"box"`` maps the points into the box alone, as in the thesis; ``"repair"`` then applies the
            problem's own rule before evaluation; the search goes on from the points before this repair.
        start: the initial mean: ``"random"``, ``objective.start_point``, or ``"midpoint"`` of the box, as in
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
        return objective.start_point()

    def evaluate(self, objective: Objective, x: Floats) -> Floats:
        """Return the (n,) values of the (n, d) points ``x`` of the box, first repaired if ``handling`` says so."""
        return np.asarray(objective(objective.repair(x) if self.handling == "repair" else x))


@dataclass(frozen=True)
class CMAES(BoxedCMA):
    """Covariance matrix adaptation evolution strategy, with pycma's defaults and stopping tolerances.

    Example:
        >>> bench.solve("signature-12", CMAES(agents=300, handling="box", start="midpoint"), budget=60_000).fun

    Source: N. Hansen, A. Ostermeier, Completely Derandomized Self-Adaptation in Evolution Strategies, Evolutionary
    Computation 9(2), 2001, doi:10.1162/106365601750190398; the code is N. Hansen's ``cma``. A stop by one of its
    tolerances (tolfun, tolx, tolstagnation, …) is declared, and leaves budget unused.

    The bounds are handled as by pycma's option ``bounds``: the search runs in an unbounded space, and a periodic,
    piecewise linear and quadratic map takes its points into the box. pycma maps single points in Python; here the same
    map, to the last bit, takes all at once.

    Attributes:
        agents, handling, start, sigma: see :class:`BoxedCMA`.
        active: whether the worse half of a generation takes variance away from its directions, by negative weights
            (pycma's ``CMA_active``).
    """

    code: ClassVar[str] = "pycma (N. Hansen's cma), run by this package"
    libraries: ClassVar[tuple[str, ...]] = ("cma",)
    bibtex: ClassVar[str] = works("hansen2001", "hansen2019")

    active: bool = True

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent or a tolerance of pycma is met."""
        from cma import CMAEvolutionStrategy

        box = BoxMap(objective.lower, objective.upper)
        width = objective.upper - objective.lower
        options = {
            **SILENT, **UNLIMITED,
            "popsize": self.population(objective.dimension),
            "CMA_active": self.active,
            "seed": np.nan,  # leaves numpy's global state alone
            "randn": lambda *shape: rng.standard_normal(shape),
        }  # fmt: skip
        step = 1.0
        if objective.dimension > 1:
            options |= {"CMA_stds": self.sigma * width, "maxstd": width * (1 / 3)}  # as pycma's own bounds do
        else:  # pycma has no coordinate-wise scales in one dimension
            step = self.sigma * float(width[0])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of flat fitness and early stops, which the harness records
            strategy = CMAEvolutionStrategy(box.inverse(self.mean(objective)), step, options)
            strategy.sm.update = partial(learn, strategy.sm)
            books = take_books(strategy)
            while not strategy.stop():
                asked = strategy.ask_geno()
                if not strategy.gp.isidentity:  # pycma searches an ill-conditioned problem in other coordinates
                    strategy.sent_solutions = books
                    coordinates, asked = asked, [strategy.gp.pheno(point) for point in asked]
                    for point, each in zip(asked, coordinates, strict=True):
                        books.insert(point, geno=each, iteration=strategy.countiter)
                f = self.evaluate(objective, box(np.asarray(asked)))
                # the points are pycma's own: they need no check, and none is pulled towards the mean
                strategy.tell(asked, f.tolist(), check_points=False)
        objective.stop(" ".join(sorted(strategy.stop())))


def take_books(strategy: Any) -> Any:
    """Have pycma look up no point that it has sent, as each comes back unchanged; return the archive of points."""
    from cma.evolution_strategy import get_CMASolutionDict

    books, strategy.sent_solutions = strategy.sent_solutions, get_CMASolutionDict(functional=False)()
    space, geno = strategy.gp, strategy.gp.geno
    space.geno = lambda y, *others, **options: y if space.isidentity else geno(y, *others, **options)
    injected, clean = strategy._injected_solutions_archive, strategy._clean_injected_solutions_archive
    strategy._clean_injected_solutions_archive = lambda points: clean(points) if len(injected) else []
    return books


def learn(model: Any, vectors: ArrayLike, weights: ArrayLike, c1_times_delta_hsigma: float = 0) -> None:
    """Do as the ``update`` of pycma's distribution does, to the last bit, with all negative weights at once.

    The weighted outer products of the (n, d) ``vectors`` are added to C (Hansen, arXiv:1604.00772, eq. 47); a negative
    weight is divided by the vector's squared Mahalanobis length (eq. 46). Sums are taken in pycma's order, and powers
    remain those of numpy's scalars, from which those of arrays differ in last digits.
    """
    x, w = np.asarray(vectors), np.array(weights)
    total, negative = w.cumsum()[-1], w < 0
    white = (model.B.T @ x[negative, :, np.newaxis])[..., 0] / model.D
    lengths = (white**2).cumsum(axis=1)[:, -1]
    w[negative] *= [model.dimension / (length**0.5 + 1e-9) ** 2 for length in lengths]
    if not (np.isfinite(x[0, 0]) and np.isfinite(lengths).all() and np.isfinite(w).all()):
        type(model).update(model, vectors, weights, c1_times_delta_hsigma)  # which raises an error
        return
    model.C *= 1 + c1_times_delta_hsigma - total
    model.C += np.dot(w * x.T, x)
    model.count_tell += 1


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
