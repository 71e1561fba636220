"""The single-objective optimizers of pymoo, as ``pymoo:DE`` and so on."""

from __future__ import annotations

import inspect
import warnings
from copy import deepcopy
from dataclasses import dataclass
from importlib import import_module
from typing import Any, ClassVar

import numpy as np

from bench.contract.objective import Objective
from bench.contract.optimizer import Optimizer
from bench.contract.typing import Floats
from optimizers.cma_es import SILENT, UNLIMITED
from optimizers.common.family import Constructed, Family, declared, global_random_state, table

FOLDER = "pymoo.algorithms.soo.nonconvex"

TABLE = table("pymoo")


@dataclass(frozen=True)
class PymooOptimizer(Constructed):
    """An algorithm of pymoo, which evaluates a generation as one batch.

    The start population, or the points of which a local search takes the best, come from ``objective.initial``.
    The budget replaces pymoo's default termination, a set of tolerances and limits. Criteria of the algorithm itself
    end a run early, and are declared: the tolerances of cma and of Nelder and Mead's simplex, and a mating that finds
    nothing new. pymoo sees values above 1e100, +inf among them, as 1e100.
    """

    start: ClassVar[str] = "random"  # objective.initial

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent, or the algorithm ends by a criterion of its own."""
        with global_random_state(rng), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the harness records what pymoo and cma warn of
            algorithm = deepcopy(self.construct())  # its operators are shared defaults of the constructor
            reason = prepare(algorithm, objective)
            problem = self._problem(objective)
            seed = int(rng.integers(1, 2**31))  # cma takes 0 for no seed
            algorithm.setup(problem, termination=algorithm.termination, seed=seed)
            while algorithm.has_next():
                algorithm.next()
        objective.stop(reason)

    def _problem(self, objective: Objective) -> object:
        """Return the objective as pymoo's problem."""
        from pymoo.core.problem import Problem

        class Box(Problem):  # type: ignore[misc]
            def _evaluate(problem, x: Floats, out: dict[str, object], *_: object, **__: object) -> None:  # noqa: N805
                out["F"] = self.finite_values(objective, x)[:, np.newaxis]

        return Box(n_var=objective.dimension, n_obj=1, xl=objective.lower, xu=objective.upper)


def prepare(algorithm: Any, objective: Objective) -> str:
    """Set the algorithm's start and length; returns the only reason for which it can end early."""
    from pymoo.algorithms.soo.nonconvex.nelder import NelderAndMeadTermination, NelderMead
    from pymoo.core.population import Population
    from pymoo.core.termination import NoTermination

    if hasattr(algorithm, "initialization"):
        algorithm.initialization.sampling = lambda _, n, **__: Population.new(X=objective.initial(n))
    if hasattr(algorithm, "max_iteration"):
        algorithm.max_iteration = -(-objective.budget // algorithm.pop_size)
    for options in ("options", "opts"):
        if hasattr(algorithm, options):
            getattr(algorithm, options).update(UNLIMITED | SILENT)
            algorithm.termination = NoTermination()
            return "a tolerance of cma"
    if isinstance(algorithm, NelderMead):
        algorithm.termination = NelderAndMeadTermination(n_max_iter=np.inf, n_max_evals=np.inf)
        return "x_tol, f_tol or a flat simplex"
    algorithm.termination = NoTermination()
    return "no new offspring"


class Pymoo(Family):
    """The family ``pymoo:<class>``: pymoo's single-objective algorithms for real variables."""

    name = "pymoo"
    module = "pymoo"
    extra = "pymoo"
    facts = TABLE

    def derive(self, member: str) -> type[Optimizer]:
        """Return the optimizer class of a pymoo class."""
        from pymoo.config import Config

        Config.warnings["not_compiled"] = False  # else pymoo prints that it runs without its compiled modules
        entry = TABLE["members"][member]
        solver = getattr(import_module(f"{FOLDER}.{entry['module']}"), member)
        return self.member_class(
            PymooOptimizer, member, {name: of_class(solver, name) for name in entry["parameters"]},
            (*entry.get("works", ()), "blank2020"), *(["cma"] if member.endswith("CMAES") else []),
            __doc__=entry["about"], unmapped=tuple(entry.get("unmapped", ())), solver=solver,
        )  # fmt: skip


pymoo = Pymoo()


def of_class(solver: type, name: str) -> tuple[object, object]:
    """Return type and default, with its range, of a parameter of a pymoo class."""
    signatures = [inspect.signature(vars(signature)["__init__"]).parameters for signature in solver.__mro__[:-1]]
    facts = TABLE["parameters"].get(name, {})
    default = next((signature[name].default for signature in signatures if name in signature), facts.get("default"))
    return declared(default, {"kind": "int", **facts} if default is None else facts)
