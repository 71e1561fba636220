"""The samplers of optuna, as ``optuna:TPESampler`` and so on."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from bench.families import derive
from bench.objective import Objective
from bench.optimizer import Optimizer, parameter
from optimizers.common.base import works
from optimizers.common.family import AGENTS, Adapter, Family, wraps


class Member(NamedTuple):
    """A sampler of optuna.

    Attributes:
        about: one line on it.
        works: the keys of its papers.
        parameters: type and default of its parameters, by optuna's names.
        start: the parameter that says how many points it begins with, which come from ``objective.initial``; "" for one
            that draws all points itself. A number is that many points.
    """

    about: str
    works: tuple[str, ...]
    parameters: dict[str, tuple[Any, Any]]
    start: str | int


MEMBERS = {
    "CmaEsSampler": Member(
        "CMA-ES by the package cmaes.",
        ("nomura2024", "hansen2001"),
        {
            "sigma0": (float | None, None),
            "popsize": (int | None, parameter(None, minimum=2)),
            "use_separable_cma": (bool, False),
            "with_margin": (bool, False),
            "lr_adapt": (bool, False),
        },
        1,
    ),
    "NSGAIISampler": Member(
        "A genetic algorithm: NSGA-II, of one objective here.",
        ("deb2002",),
        {
            "population_size": (int, parameter(50, minimum=2)),
            "mutation_prob": (float | None, parameter(None, minimum=0, maximum=1)),
            "crossover_prob": (float, parameter(0.9, minimum=0, maximum=1)),
            "swapping_prob": (float, parameter(0.5, minimum=0, maximum=1)),
        },
        "population_size",
    ),
    "QMCSampler": Member(
        "Points of a quasi-random sequence; scrambled, unlike optuna's default, whose runs are all equal.",
        ("bergstra2012",),
        {"qmc_type": (Literal["sobol", "halton"], "sobol"), "scramble": (bool, True)},
        0,
    ),
    "RandomSampler": Member("Uniform random points.", ("brooks1958",), {}, 0),
    "TPESampler": Member(
        "The tree-structured Parzen estimator.",
        ("bergstra2011", "watanabe2023"),
        {
            "n_startup_trials": (int, parameter(10, minimum=0)),
            "n_ei_candidates": (int, parameter(24, minimum=1)),
            "multivariate": (bool | None, None),
        },
        "n_startup_trials",
    ),
}


@dataclass(frozen=True)
class OptunaOptimizer(Adapter):
    """A sampler of optuna, run by its ask and tell, one point after the other.

    optuna sees values above 1e100, +inf among them, as 1e100. It keeps every evaluation as a trial of its own, so that
    an evaluation takes longer and longer: TPE 1 ms among 100, 8 ms among 1,500.
    """

    member: ClassVar[str]  # optuna's class

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent."""
        import optuna

        sampled = MEMBERS[self.member]
        options = {name: getattr(self, AGENTS.get(name, name)) for name in sampled.parameters}
        first = options[sampled.start] if isinstance(sampled.start, str) else sampled.start
        names = [f"x{index}" for index in range(objective.dimension)]
        box = zip(objective.lower.tolist(), objective.upper.tolist(), strict=True)
        uniform: Any = optuna.distributions.FloatDistribution
        ranges = {name: uniform(*ends) for name, ends in zip(names, box, strict=True)}
        with _quiet(optuna):
            sampler = getattr(optuna.samplers, self.member)(seed=int(rng.integers(2**32)), **options)
            study = optuna.create_study(sampler=sampler)
            for point in objective.initial(min(first, objective.budget)).tolist() if first else ():
                study.enqueue_trial(dict(zip(names, point, strict=True)))
            while objective.remaining:
                trial = study.ask(ranges)
                x = np.array([[trial.params[name] for name in names]])
                study.tell(trial, float(self.finite_values(objective, x)[0]))


@contextmanager
def _quiet(optuna: Any) -> Iterator[None]:
    """Let optuna print and warn of nothing; its level of messages is as before afterwards."""
    level = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        optuna.logging.set_verbosity(level)


class Optuna(Family):
    """The family ``optuna:<class>``: optuna's samplers of real variables."""

    name = "optuna"
    module = "optuna"
    extra = "optuna"
    left_out: ClassVar[dict[str, list[str]]] = {
        "it is for several objectives": ["NSGAIIISampler"],
        "it needs a package of neural networks, torch": ["GPSampler"],
        "it searches a finite set of points": ["BruteForceSampler", "GridSampler"],
        "it wraps another sampler": ["PartialFixedSampler"],
    }

    def members(self) -> list[str]:
        """Return the names of optuna's classes in the table."""
        return list(MEMBERS)

    def derive(self, member: str) -> type[Optimizer]:
        """Return the optimizer class of a sampler."""
        facts = MEMBERS[member]
        return derive(
            OptunaOptimizer,
            f"optuna:{member}",
            {AGENTS.get(name, name): declared for name, declared in facts.parameters.items()},
            self.load,
            member=member,
            **wraps("optuna", *(["cmaes"] if member == "CmaEsSampler" else [])),
            bibtex=works(*facts.works, "akiba2019"),
            unmapped=("the parameters that are objects or functions keep optuna's values",),
            __doc__=facts.about,
        )


optuna = Optuna()
