"""The global optimizers of ``scipy.optimize``, as ``"scipy:differential_evolution"``, ``"scipy:dual_annealing"``, …"""

from __future__ import annotations

import logging
import warnings
from abc import abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, ClassVar, Literal

import numpy as np

from bench.contract.objective import Objective
from bench.contract.optimizer import Optimizer, parameter, settings
from bench.contract.typing import Floats
from optimizers.common.base import works
from optimizers.common.family import CEILING, Adapter, Family

CEILED = f"values above {CEILING:g}, such as +inf, are {CEILING:g} to it: a difference of infinities is no slope"


@dataclass(frozen=True)
class ScipyOptimizer(Adapter):
    """A global optimizer of ``scipy.optimize``."""

    libraries: ClassVar[tuple[str, ...]] = ("scipy",)
    code: ClassVar[str] = f"scipy {version('scipy')}"
    ceiling: ClassVar[float] = np.inf  # the greatest value that scipy sees

    solver: ClassVar[str]  # the name of scipy's function
    criterion: ClassVar[str]  # the one by which scipy can end before the budget does

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent or scipy ends by a criterion of its own, which is declared."""
        from scipy import optimize

        try:
            with silence():
                result = getattr(optimize, self.solver)(self.target(objective), **self.arguments(objective, rng))
                objective.stop(self.reason(result))
        except (RuntimeError, SystemError) as error:  # by scipy, from an error of the problem or the end of the budget
            raise error.__cause__ or error from None

    def target(self, objective: Objective) -> Callable[[Floats], object]:
        """Return the function of one (d,) point that scipy minimises."""
        return lambda x: min(float(self.values(objective, np.atleast_2d(x))[0]), self.ceiling)

    @abstractmethod
    def arguments(self, objective: Objective, rng: np.random.Generator) -> dict[str, object]:
        """Return the other arguments of scipy's function, which leave its length to the budget."""

    def passed(self, *others: str) -> dict[str, object]:
        """Return the parameters that scipy has too, by name: all but ``handling`` and ``others``."""
        return {name: value for name, value in settings(self).items() if name not in ("handling", *others)}

    def reason(self, result: Any) -> str:  # noqa: ARG002 - for subclasses
        """Return the criterion by which scipy ended with ``result``."""
        return self.criterion


@dataclass(frozen=True)
class DifferentialEvolution(ScipyOptimizer):
    """Differential evolution (Storn and Price 1997) as scipy has it, with a polish by L-BFGS-B once it has converged.

    Attributes:
        agents: the population size; None is scipy's 15 d. (scipy's ``popsize`` is this size over d.)
        strategy: how a trial vector is made: the base vector, the number of differences, the crossover.
        mutation: F, the weight of the differences; with ``mutation_to`` the lower end of its dither.
        mutation_to: every generation draws its F from between ``mutation`` and this; None keeps F fixed.
        recombination: CR, the probability of crossover.
        updating: ``"immediate"`` lets trial vectors profit from others of their generation, evaluated one by one;
            ``"deferred"`` evaluates a generation in one batch.
        polish: whether L-BFGS-B goes on from the best point once the population has converged.
        tol: the population has converged where its values' standard deviation is at most atol + tol |their mean|.
        atol: see ``tol``.
    """

    start: ClassVar[str] = "random"  # objective.initial
    solver: ClassVar[str] = "differential_evolution"
    criterion: ClassVar[str] = "tol"
    bibtex: ClassVar[str] = works("storn1997", "virtanen2020")
    unmapped: ClassVar[tuple[str, ...]] = (
        "its start population is the harness's uniform one, not a Latin hypercube (init)",
        "it is polished when it has converged, not when the budget ends",
    )

    agents: int | None = parameter(None, minimum=5)
    strategy: Literal[
        "best1bin", "best1exp", "best2bin", "best2exp", "rand1bin", "rand1exp", "rand2bin", "rand2exp",
        "randtobest1bin", "randtobest1exp", "currenttobest1bin", "currenttobest1exp",
    ] = "best1bin"  # fmt: skip
    mutation: float = parameter(0.5, minimum=0, maximum=1.999)
    mutation_to: float | None = parameter(1.0, minimum=0, maximum=1.999)
    recombination: float = parameter(0.7, minimum=0, maximum=1)
    updating: Literal["immediate", "deferred"] = "immediate"
    polish: bool = True
    tol: float = parameter(0.01, minimum=0)
    atol: float = parameter(0.0, minimum=0)

    def target(self, objective: Objective) -> Callable[[Floats], object]:
        """Return the function of one (d,) point or, for deferred updating, of (d, n) points that scipy minimises."""
        if self.updating == "immediate":
            return super().target(objective)
        return lambda x: self.values(objective, x.T)

    def arguments(self, objective: Objective, rng: np.random.Generator) -> dict[str, object]:
        """Return the arguments of scipy's function; see :meth:`ScipyOptimizer.arguments`."""
        agents = self.agents if self.agents is not None else max(5, 15 * objective.dimension)
        return self.passed("agents", "mutation_to") | {
            "bounds": box(objective),
            "maxiter": objective.budget,
            "mutation": self.mutation if self.mutation_to is None else (self.mutation, self.mutation_to),
            "init": objective.initial(agents),
            "vectorized": self.updating == "deferred",
            "rng": rng,
        }


@dataclass(frozen=True)
class DualAnnealing(ScipyOptimizer):
    """Generalized simulated annealing (Xiang et al. 1997) with a local search by L-BFGS-B, restarted when it is cold.

    Attributes:
        initial_temp: the temperature at the start and after every restart.
        restart_temp_ratio: the search restarts when the temperature falls below this part of ``initial_temp``.
        visit: the visiting distribution's parameter; the greater, the heavier its tail.
        accept: the acceptance distribution's parameter; the lower, the rarer a worse point is accepted.
        no_local_search: leave the local search out.
    """

    start: ClassVar[str] = "random"  # objective.initial
    solver: ClassVar[str] = "dual_annealing"
    criterion: ClassVar[str] = "maxiter"
    bibtex: ClassVar[str] = works("xiang1997", "virtanen2020")
    ceiling: ClassVar[float] = CEILING
    unmapped: ClassVar[tuple[str, ...]] = (CEILED,)

    # The ranges that scipy accepts.
    initial_temp: float = parameter(5230.0, minimum=0.01, maximum=5e4)
    restart_temp_ratio: float = parameter(2e-5, minimum=1e-15, maximum=0.999)
    visit: float = parameter(2.62, minimum=1.001, maximum=2.999)
    accept: float = parameter(-5.0, minimum=-1e4, maximum=-5)
    no_local_search: bool = False

    def arguments(self, objective: Objective, rng: np.random.Generator) -> dict[str, object]:
        """Return the arguments of scipy's function; see :meth:`ScipyOptimizer.arguments`."""
        return self.passed() | {
            "bounds": box(objective),
            "maxiter": objective.budget,
            "maxfun": np.inf,
            "x0": objective.start_point(),
            "rng": rng,
        }


@dataclass(frozen=True)
class Direct(ScipyOptimizer):
    """DIRECT, dividing rectangles (Jones et al. 1993), locally biased by default (Gablonsky and Kelley 2001).

    Attributes:
        eps: the least improvement on the best value that a rectangle must promise to be divided; the smaller, the more
            local the search.
        locally_biased: False is the original of 1993.
        vol_tol: the search ends when the best point's rectangle has less than this part of the box's volume.
        len_tol: the search ends when half of that rectangle's longest side (of its diagonal, unless locally biased) is
            less than this part of the box's.
    """

    solver: ClassVar[str] = "direct"
    bibtex: ClassVar[str] = works("jones1993", "gablonsky2001", "virtanen2020")
    unmapped: ClassVar[tuple[str, ...]] = (
        "deterministic: neither the seed nor the harness's start points change anything",
    )

    eps: float = parameter(1e-4, minimum=0)
    locally_biased: bool = True
    vol_tol: float = parameter(1e-16, minimum=0, maximum=1)
    len_tol: float = parameter(1e-6, minimum=0, maximum=1)

    def arguments(self, objective: Objective, rng: np.random.Generator) -> dict[str, object]:  # noqa: ARG002 - draws nothing
        """Return the arguments of scipy's function; see :meth:`ScipyOptimizer.arguments`."""
        return self.passed() | {"bounds": box(objective), "maxfun": objective.budget + 1, "maxiter": objective.budget}

    def reason(self, result: Any) -> str:
        """Return the criterion by which scipy ended with ``result``."""
        return {4: "vol_tol", 5: "len_tol"}.get(result.status) or str(result.message)


@dataclass(frozen=True)
class BasinHopping(ScipyOptimizer):
    """Basin hopping (Wales and Doye 1997): random hops, each followed by L-BFGS-B, and a Metropolis test.

    Attributes:
        T: the temperature of the Metropolis test, in units of the objective's values.
        stepsize: the longest hop at the start in every coordinate, in units of the box's width.
        interval: the number of hops after which the step size adapts.
        target_accept_rate: the part of hops to accept, towards which the step size adapts.
        stepwise_factor: the factor or divisor of the step size when it adapts.
        niter_success: the number of hops without a better minimum after which the search ends; None for no limit.
    """

    start: ClassVar[str] = "random"  # objective.initial
    solver: ClassVar[str] = "basinhopping"
    criterion: ClassVar[str] = "niter_success"
    bibtex: ClassVar[str] = works("wales1997", "virtanen2020")
    ceiling: ClassVar[float] = CEILING
    unmapped: ClassVar[tuple[str, ...]] = (
        CEILED,
        "hops are measured in the box's width, not in the units of x: scipy's 0.5 is 0.05 of the box [-5, 5]",
        "its local search is L-BFGS-B within the box, not scipy's unbounded BFGS, and starts from hops clipped to it",
    )

    # The temperature is in units of the objective; the step is a share of the box's width.
    T: float = parameter(1.0, minimum=0)
    stepsize: float = parameter(0.05, minimum=1e-12, maximum=1)
    interval: int = parameter(50, minimum=1)
    target_accept_rate: float = parameter(0.5, minimum=0.001, maximum=0.999)
    stepwise_factor: float = parameter(0.9, minimum=0.001, maximum=0.999)
    niter_success: int | None = parameter(None, minimum=1)

    def arguments(self, objective: Objective, rng: np.random.Generator) -> dict[str, object]:
        """Return the arguments of scipy's function; see :meth:`ScipyOptimizer.arguments`."""
        return self.passed("stepsize") | {
            "x0": objective.start_point(),
            "niter": objective.budget,
            "minimizer_kwargs": {"method": "L-BFGS-B", "bounds": box(objective)},
            "take_step": Hop(self.stepsize, objective, rng),
            "rng": rng,
        }


@dataclass
class Hop:
    """A uniform displacement within the box; scipy adapts ``stepsize``, which is in units of the box's width."""

    stepsize: float
    objective: Objective
    rng: np.random.Generator

    def __call__(self, x: Floats) -> Floats:
        """Return the (d,) end point of a hop from ``x``."""
        lower, upper = self.objective.lower, self.objective.upper
        step = self.rng.uniform(-self.stepsize, self.stepsize, len(x)) * (upper - lower)
        return np.clip(x + step, lower, upper)


def box(objective: Objective) -> list[tuple[float, float]]:
    """Return the box as d pairs (lower, upper)."""
    return list(zip(objective.lower.tolist(), objective.upper.tolist(), strict=True))


@contextmanager
def silence() -> Iterator[None]:
    """Keep scipy's warnings and log lines from the terminal, and the log's handlers as they were."""
    root, disabled, handler = logging.getLogger(), logging.root.manager.disable, logging.NullHandler()
    root.addHandler(handler)  # logging.info(…), as scipy calls it, gives a log without a handler one of its own
    logging.disable(logging.CRITICAL)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of infinite values, flat functions, local searches that failed
            yield
    finally:
        logging.disable(disabled)
        root.removeHandler(handler)


MEMBERS = {cls.solver: cls for cls in (BasinHopping, DifferentialEvolution, Direct, DualAnnealing)}


class Scipy(Family):
    """The family ``scipy:<function>``; ``brute`` and ``shgo``, on grids, are left out: they spend no given budget."""

    name = "scipy"
    module = "scipy.optimize"

    def members(self) -> list[str]:
        """Return the names of scipy's functions."""
        return list(MEMBERS)

    def derive(self, member: str) -> type[Optimizer]:
        """Return the class of a member."""
        return MEMBERS[member]


scipy = Scipy()
