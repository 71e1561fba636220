"""The optimizers of mealpy, as ``mealpy:OriginalGWO`` and so on."""

from __future__ import annotations

import inspect
import re
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from typing import Any, ClassVar, Literal

import numpy as np

from bench.contract.objective import Objective
from bench.contract.optimizer import Optimizer, parameter
from bench.contract.typing import Floats
from bench.helpers.errors import BenchError
from optimizers.common.family import Constructed, Family, global_random_state, table

LEAST_EPOCHS = 2
"""The shortest schedule: some formulas divide by the number of epochs less 1."""

IDLE_EPOCHS = 1000
"""A search ends after this number of epochs without an evaluation."""

TABLE = table("mealpy")

TWO_VARIABLES = "It needs at least two variables."
"""The table's remark on classes that fail in one dimension."""

PLANNED_AT_START: dict[str, Callable[[Any], float]] = {
    "DevBRO": lambda model: 1.8 * model.pop_size,
    "DevDMOA": lambda model: 3.1 * model.pop_size,
    "OriginalCRO": lambda model: 0.48 * model.pop_size,
    "OriginalEFO": lambda _: 1,
    "SwarmSA": lambda model: model.max_sub_iter * model.move_count * model.pop_size,
}
"""Evaluations of an epoch, for classes that fix their schedule before the first; numbers with a point are measured."""


@dataclass(frozen=True)
class MealpyOptimizer(Constructed):
    """An algorithm of mealpy.

    mealpy plans in epochs. Most algorithms evaluate ``agents`` points at the start and as many in an epoch, and a
    budget of N (T + 1) evaluations makes T epochs. Where an epoch takes more or fewer evaluations, T is planned anew
    after each epoch from the evaluations so far, so that the schedule ends with the budget.

    Every point that mealpy draws uniformly in the box, the start population first, comes from ``objective.initial``.
    mealpy sees values above 1e100, +inf among them, as 1e100.
    """

    start: ClassVar[str] = "random"  # objective.initial

    agents: int = parameter(100, minimum=2)

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent or mealpy evaluates no more.

        Raises:
            BenchError: on a problem of one variable, for the algorithms that need two.
        """
        if objective.dimension == 1 and TWO_VARIABLES in self.unmapped:
            raise BenchError(f"mealpy:{type(self).__name__} needs at least two variables, and the problem has one")
        with global_random_state(rng), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # overflows and divisions by zero in mealpy's formulas
            self._search(objective, int(rng.integers(2**31)))

    def _search(self, objective: Objective, seed: int) -> None:
        """Run mealpy's ``solve`` step by step, without its progress history and its stopping criteria."""
        model = self.construct()
        planned = PLANNED_AT_START.get(type(self).__name__)
        cost = planned(model) if planned else model.pop_size
        model.epoch = max(LEAST_EPOCHS, -int(-(objective.budget - model.pop_size) // cost))
        self._connect(model, objective, seed)
        model.initialize_variables()
        model.initialization()
        model.after_initialization()
        model.before_main_loop()
        start, idle = objective.nfev, 0
        for epoch in count(1):
            if not objective.remaining:
                return
            before = objective.nfev
            model.epoch = max(LEAST_EPOCHS, epoch - 1 - int(-objective.remaining // cost))
            model.evolve(epoch)
            ordered, model.g_best = model.update_global_best_agent(model.pop)
            if model.sort_flag:
                model.pop = ordered
            cost = max((objective.nfev - start) / epoch, 1 / IDLE_EPOCHS)
            idle = 0 if objective.nfev > before else idle + 1
            if idle == IDLE_EPOCHS:
                objective.stop(f"no evaluation in {IDLE_EPOCHS} epochs")
                return

    def _connect(self, model: Any, objective: Objective, seed: int) -> None:
        """Give the model its problem, its seed and its mode, as the first lines of mealpy's ``solve`` do."""
        from mealpy import FloatVar, Problem
        from mealpy.utils.target import Target

        class Box(FloatVar):  # type: ignore[misc]
            def generate(self) -> Floats:
                point: Floats = objective.initial(1)[0]
                return point

        def update_target_for_population(pop: list[Any]) -> list[object]:
            if model.mode == "swarm" and pop:
                values = self.finite_values(objective, np.array([agent.solution for agent in pop]))
                for agent, value in zip(pop, values, strict=True):
                    agent.target = Target(float(value), problem.obj_weights)
            return pop

        def value(x: Floats) -> float:
            return float(self.finite_values(objective, x[np.newaxis])[0])

        problem = Problem(Box(objective.lower, objective.upper), "min", log_to=None, obj_func=value)
        model.check_problem(problem, seed)
        model.check_mode_and_workers(getattr(self, "mode", "single"), None)
        model.check_termination("start", None, None)
        model.update_target_for_population = update_target_for_population


class Mealpy(Family):
    """The family ``mealpy:<class>``: the classes that ``mealpy.get_all_optimizers`` lists."""

    name = "mealpy"
    module = "mealpy"
    extra = "mealpy"
    facts = TABLE

    def members(self) -> list[str]:
        """Return the names of mealpy's classes but those left out."""
        return [name for name in self.require().get_all_optimizers(verbose=False) if not self.why_left_out(name)]

    def derive(self, member: str) -> type[Optimizer]:
        """Return the optimizer class of a mealpy class, with the parameters of its constructor."""
        solver = self.require().get_all_optimizers(verbose=False)[member]
        accepted = constructor_parameters(solver)
        parameters = dict(accepted)
        if solver().is_parallelizable and member not in TABLE["no_swarm"]:
            parameters["mode"] = (Literal["single", "swarm"], "single")
        unmapped = tuple(sentence for sentence, members in TABLE["remarks"].items() if member in members)
        return self.member_class(
            MealpyOptimizer, member, parameters, (*TABLE["works"].get(member, ()), "vanthieu2023"),
            __doc__=describe(solver), unmapped=unmapped, solver=solver, own=tuple(accepted),
        )  # fmt: skip


mealpy = Mealpy()


class _Checks(dict[str, tuple[str, object]]):
    """Replaces a model's validator, and records the kind and the bounds of every check."""

    def __getattr__(self, check: str) -> Callable[..., object]:
        def note(name: str, value: object, bound: object = None, *_: object) -> object:
            self[name] = (check, bound)
            return value

        return note


def constructor_checks(solver: type, agents: int) -> dict[str, tuple[str, object]]:
    """Return, by parameter, kind and bounds of the check that mealpy makes in a ``solver`` with ``agents`` agents."""
    checks = _Checks()
    watched = property(lambda _: checks, lambda _, __: None)
    type(solver.__name__, (solver,), {"validator": watched})(pop_size=agents)
    return checks


def constructor_parameters(solver: type) -> dict[str, tuple[object, object]]:
    """Return type and default of each parameter of a mealpy class.

    The ends of mealpy's open intervals pass here, as do ranges that depend on the number of agents; mealpy checks both.
    """
    defaults = {
        name: argument.default
        for name, argument in inspect.signature(solver).parameters.items()
        if name != "epoch" and argument.kind is not argument.VAR_KEYWORD
    }
    checks = constructor_checks(solver, defaults["pop_size"])
    others = constructor_checks(solver, 2 * defaults["pop_size"])
    made: dict[str, tuple[object, object]] = {}
    for name, default in defaults.items():
        check, bounds = checks.get(name, ("", None))
        if checks.get(name) != others.get(name):
            bounds = None
        made[name] = declared(default, check, bounds)
    return made


def declared(default: object, check: str, bounds: Any) -> tuple[object, object]:
    """Return type and default, with its range, of a parameter from the kind and the bounds of mealpy's check."""
    if isinstance(default, bool):
        return bool, default
    if isinstance(default, str):
        return (Literal[tuple(bounds)] if bounds else str), default
    low, high = bounds if bounds and check in ("check_int", "check_float") else (None, None)
    kind = int if isinstance(default, int) and check != "check_float" else float
    return kind, parameter(default, minimum=low, maximum=high)


def describe(solver: type) -> str:
    """Return the docstring of a member: the title and the sources in the docstring of mealpy's class."""
    text = inspect.getdoc(solver) or solver.__name__
    title = " ".join(text.splitlines()[0].split()).rstrip(".")
    sources = re.split(r"\[\d+\]", text.partition("References\n")[2])[1:]
    cited = [" ".join(work.split()).rstrip(".") for work in sources]
    return f"{title}." + (f"\n\nmealpy names as its source: {'; '.join(cited)}." if cited else "")
