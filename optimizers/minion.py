"""The optimizers of minionpy, as ``minion:LSHADE``, ``minion:jSO`` and so on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from bench.contract.objective import Objective
from bench.contract.optimizer import Optimizer
from bench.contract.typing import Floats
from optimizers.common.family import Adapter, Family, declared, table

TABLE = table("minion")

Function = Callable[[list[list[float]]], list[float]]


@dataclass(frozen=True)
class MinionOptimizer(Adapter):
    """An algorithm of minionpy, written in C++, which evaluates a generation as one batch, in one thread.

    A start population comes from ``objective.initial``, in the size that minionpy plans; an algorithm that starts from
    one point starts from one of these points. The budget is the length of minionpy's schedules. It asks for some
    evaluations more than that, which the objective refuses. Its tolerances end a run early, and are declared. minionpy
    sees values above 1e100, +inf among them, as 1e100.
    """

    start: ClassVar[str] = "random"  # objective.initial
    from_point: ClassVar[bool]  # whether it starts from one point

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent, or minionpy ends by a tolerance."""
        start = objective.start_point()[np.newaxis] if self.from_point else objective.initial(self._planned(objective))
        raised: list[BaseException] = []

        def values(points: list[list[float]]) -> list[float]:
            try:
                answers: list[float] = self.finite_values(objective, np.array(points)).tolist()
            except BaseException as error:
                raised.append(error)
                raise
            return answers

        try:
            result = self._minimizer(values, objective, start, int(rng.integers(2**31))).optimize()
        except RuntimeError:  # most algorithms turn an exception, the end of the budget too, into this one
            if not raised:
                raise
        if raised:
            raise raised[0]
        spent = str(result.status) == "max_evaluations_reached"  # LSRTDE says so of other ends too
        objective.stop("for no reason that minionpy names" if spent else result.message)

    def _planned(self, objective: Objective) -> int:
        """Return the size of minionpy's start population: that of the first batch, which is not evaluated here."""
        sizes: list[int] = []

        def refuse(points: list[list[float]]) -> list[float]:
            sizes.append(len(points))
            raise RuntimeError("only the size of the first batch is wanted")

        middle = (objective.lower + objective.upper)[np.newaxis] / 2
        try:
            self._minimizer(refuse, objective, middle, 0).optimize()
        except RuntimeError:
            if not sizes:
                raise
        return sizes[0]

    def _minimizer(self, function: Function, objective: Objective, start: Floats, seed: int) -> Any:
        """Return minionpy's object. Its ``Minimizer`` runs JADE by that name; its class JADE runs L-SHADE."""
        from minionpy import Minimizer

        options = self.options()
        if "population_size" in options:
            options["population_size"] = options["population_size"] or 0  # minionpy's own rule
        return Minimizer(
            func=function, bounds=list(zip(objective.lower.tolist(), objective.upper.tolist(), strict=True)),
            x0=start.tolist(), algo=self.member, maxevals=objective.budget, seed=seed, options=options,
        )  # fmt: skip


class Minion(Family):
    """The family ``minion:<algorithm>``: the algorithms of minionpy's ``Minimizer``."""

    name = "minion"
    module = "minionpy"
    extra = "minion"
    facts = TABLE

    def derive(self, member: str) -> type[Optimizer]:
        """Return the optimizer class of an algorithm of minionpy."""
        entry = TABLE["members"][member]
        parameters = {
            name: declared(default, TABLE["parameters"].get(name, {})) for name, default in entry["parameters"].items()
        }
        return self.member_class(
            MinionOptimizer, member, parameters, (*entry["works"], "muzakka2025"), __doc__=entry["about"],
            unmapped=tuple(entry.get("unmapped", ())), from_point=entry.get("from_point", False),
        )  # fmt: skip


minion = Minion()
