"""CMA-ES as the ``cma`` package (pycma) runs it, with its handling of bounds vectorised."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import cma
import numpy as np

from bench.objective import Objective
from bench.optimizer import Optimizer, parameter
from bench.problem import Floats
from optimizers._population import compiled

UNLIMITED: dict[str, Any] = {"maxiter": np.inf, "maxfevals": np.inf}
"""pycma's own limits on length are off: the harness's budget ends a trial, or a tolerance of pycma does."""

SILENT: dict[str, Any] = {"verbose": -9, "verb_log": 0, "verb_disp": 0, "signals_filename": None}


@dataclass(frozen=True)
class CMAES(Optimizer):
    """Covariance matrix adaptation evolution strategy, with pycma's defaults and stopping tolerances.

    Example:
        >>> bench.solve("signature-12", CMAES(agents=300, handling="box", start="midpoint"), budget=60_000).fun

    Source: N. Hansen, A. Ostermeier, Completely Derandomized Self-Adaptation in Evolution Strategies, Evolutionary
    Computation 9(2), 2001, doi:10.1162/106365601750190398; the code is N. Hansen's ``cma``. A stop by one of its
    tolerances (tolfun, tolx, tolstagnation, …) is declared, and leaves budget unused.

    The box is kept as by pycma's option ``bounds``: the search runs in an unbounded space, and a piecewise linear and
    quadratic, periodic map takes its points into the box. pycma maps them one by one in Python; here the same map,
    to the last bit, takes all at once.

    Attributes:
        agents: the population size lambda; None is pycma's 4 + floor(3 ln d). The thesis uses 300.
        handling: ``"box"`` maps the points into the box alone, as in the thesis; ``"repair"`` then applies the
            problem's own rule before evaluation, which the search does not see (it goes on from the points unrepaired).
        start: the initial mean: ``"random"``, a point of ``objective.initial``, or ``"midpoint"`` of the box, as in
            section 7.1.1 of the thesis.
        sigma: the initial standard deviation in units of the box's width; 1/4 in section 7.1.1.
    """

    bibtex: ClassVar[str] = """
        @article{hansen2001,
          author = {Hansen, Nikolaus and Ostermeier, Andreas},
          title = {Completely Derandomized Self-Adaptation in Evolution Strategies},
          journal = {Evolutionary Computation},
          volume = {9},
          number = {2},
          pages = {159--195},
          year = {2001},
          doi = {10.1162/106365601750190398},
        }
        @misc{hansen2019,
          author = {Hansen, Nikolaus and Akimoto, Youhei and Baudis, Petr},
          title = {{CMA-ES}/pycma on {Github}},
          howpublished = {Zenodo},
          year = {2019},
          doi = {10.5281/zenodo.2559634},
        }
    """

    agents: int | None = parameter(None, minimum=4)
    handling: Literal["repair", "box"] = "repair"
    start: Literal["random", "midpoint"] = "random"
    sigma: float = parameter(0.25, minimum=1e-9, maximum=10.0)

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent or a tolerance of pycma is met."""
        lower, upper = objective.lower, objective.upper
        options = {
            **SILENT, **UNLIMITED,
            "popsize": self.agents if self.agents is not None else 4 + int(3 * np.log(objective.dimension)),
            "seed": np.nan,  # leaves numpy's global state alone
            "randn": lambda *shape: rng.standard_normal(shape),
        }  # fmt: skip
        step = 1.0
        if objective.dimension > 1:
            # pycma's own bounds set the same maximum
            options |= {"CMA_stds": self.sigma * (upper - lower), "maxstd": (upper - lower) / 3}
        else:  # pycma has no coordinate-wise scales in one dimension
            step = self.sigma * float(upper[0] - lower[0])
        mean = (lower + upper) / 2 if self.start == "midpoint" else objective.initial(1)[0]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # pycma warns of what the harness records: flat fitness, early stops
            strategy = cma.CMAEvolutionStrategy(from_box(mean, lower, upper), step, options)
            while not strategy.stop():
                asked = strategy.ask()
                x = to_box(np.array(asked), lower, upper)
                f = objective(objective.repair(x) if self.handling == "repair" else x)
                strategy.tell(asked, f.tolist())
        objective.stop(" ".join(sorted(strategy.stop())))


def margins(lower: Floats, upper: Floats) -> tuple[Floats, Floats]:
    """Return the widths of the quadratic ends of the map at the (d,) bounds (pycma: margin_width2)."""
    half = (upper - lower) / 2
    return np.minimum(half, np.maximum(1, np.abs(lower)) / 20), np.minimum(half, np.maximum(1, np.abs(upper)) / 20)


def to_box(x: Floats, lower: Floats, upper: Floats) -> Floats:
    """Return the (n, d) unbounded points mapped into the box (pycma: BoxConstraintsLinQuadTransformation)."""
    return _to_box(x, lower, upper, *margins(lower, upper))


def from_box(x: Floats, lower: Floats, upper: Floats) -> Floats:
    """Return a pre-image of the (d,) point ``x`` of the box."""
    below, above = margins(lower, upper)
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
