"""CMA-ES as the ``cma`` package (pycma) runs it, with its handling of bounds vectorised."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from bench.objective import Objective
from bench.problem import Floats
from optimizers.common.cma import BoxedCMA, BoxMap
from optimizers.common.references import works

if TYPE_CHECKING:
    import cma

UNLIMITED: dict[str, Any] = {"maxiter": np.inf, "maxfevals": np.inf}
"""Options that switch pycma's limits on length off: the budget ends a trial, or a tolerance of pycma does."""

SILENT: dict[str, Any] = {"verbose": -9, "verb_log": 0, "verb_disp": 0, "signals_filename": None}


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
    map, to the last bit, takes all at once. pycma's archive of the points it has sent is left out where it would map
    each point to itself.

    Attributes:
        agents, handling, start, sigma: see :class:`~optimizers.common.cma.BoxedCMA`.
    """

    code: ClassVar[str] = "pycma (N. Hansen's cma), run by this package"
    bibtex: ClassVar[str] = works("hansen2001", "hansen2019")

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent or a tolerance of pycma is met."""
        import cma

        box = BoxMap(objective.lower, objective.upper)
        width = objective.upper - objective.lower
        options = {
            **SILENT, **UNLIMITED,
            "popsize": self.population(objective.dimension),
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
            strategy = cma.CMAEvolutionStrategy(box.inverse(self.mean(objective)), step, options)
            strategy.sent_solutions = cma.evolution_strategy.get_CMASolutionDict(functional=False)()
            while not strategy.stop():
                asked = ask(strategy)
                f = self.evaluate(objective, box(np.asarray(asked)))
                # the points are pycma's own: they need no check, and none is pulled towards the mean
                strategy.tell(asked, f.tolist(), check_points=False)
        objective.stop(" ".join(sorted(strategy.stop())))


def ask(strategy: cma.CMAEvolutionStrategy) -> list[Floats] | Floats:
    """Return the lambda unbounded points of ``strategy.ask()``, without a copy and an archive entry for each.

    Once pycma searches an ill-conditioned problem in other coordinates (its ``alleviate_conditioning``), ``tell``
    needs the archive to find a point's coordinates to the last bit.
    """
    points: Floats = strategy.ask_geno()
    if strategy.gp.isidentity:
        return points
    from cma.evolution_strategy import get_CMASolutionDict

    if isinstance(strategy.sent_solutions, get_CMASolutionDict(functional=False)):
        strategy.sent_solutions = get_CMASolutionDict(functional=True)()
    mapped = [strategy.gp.pheno(point, copy=True) for point in points]
    for image, point in zip(mapped, points, strict=True):
        strategy.sent_solutions.insert(image, geno=point, iteration=strategy.countiter)
    return mapped
