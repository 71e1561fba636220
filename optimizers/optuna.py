"""The samplers of optuna, as ``optuna:TPESampler`` and so on."""

from __future__ import annotations

import warnings
from contextlib import ExitStack
from dataclasses import dataclass

import numpy as np

from bench.contract.objective import Objective
from bench.contract.optimizer import Optimizer
from optimizers.common.family import Adapter, Family, declared, table

TABLE = table("optuna")


@dataclass(frozen=True)
class OptunaOptimizer(Adapter):
    """A sampler of optuna, run by its ask and tell, one point after the other.

    optuna sees values above 1e100, +inf among them, as 1e100. It keeps every evaluation as a trial of its own, so that
    an evaluation takes longer and longer: TPE 1 ms among 100, 8 ms among 1,500.
    """

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent."""
        import optuna

        options, start = self.options(), TABLE["members"][self.member]["start"]
        first = options[start] if isinstance(start, str) else start
        names = [f"x{index}" for index in range(objective.dimension)]
        box = zip(objective.lower.tolist(), objective.upper.tolist(), strict=True)
        uniform = optuna.distributions.FloatDistribution
        ranges = {name: uniform(*ends) for name, ends in zip(names, box, strict=True)}
        with warnings.catch_warnings(), ExitStack() as after:
            warnings.simplefilter("ignore")
            after.callback(optuna.logging.set_verbosity, optuna.logging.get_verbosity())
            optuna.logging.set_verbosity(optuna.logging.ERROR)
            sampler = getattr(optuna.samplers, self.member)(seed=int(rng.integers(2**32)), **options)
            study = optuna.create_study(sampler=sampler)
            for point in objective.initial(min(first, objective.budget)).tolist() if first else ():
                study.enqueue_trial(dict(zip(names, point, strict=True)))
            while objective.remaining:
                trial = study.ask(ranges)
                x = np.array([[trial.params[name] for name in names]])
                study.tell(trial, float(self.finite_values(objective, x)[0]))


class Optuna(Family):
    """The family ``optuna:<class>``: optuna's samplers of real variables."""

    name = "optuna"
    module = "optuna"
    extra = "optuna"
    facts = TABLE

    def derive(self, member: str) -> type[Optimizer]:
        """Return the optimizer class of a sampler."""
        entry = TABLE["members"][member]
        return self.member_class(
            OptunaOptimizer, member,
            {name: declared(facts.get("default"), facts) for name, facts in entry["parameters"].items()},
            (*entry["works"], "akiba2019"), *(["cmaes"] if member == "CmaEsSampler" else []),
            unmapped=("the parameters that are objects or functions keep optuna's values",), __doc__=entry["about"],
        )  # fmt: skip


optuna = Optuna()
