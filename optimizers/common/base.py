"""The base class of the algorithms written here, their handling of bounds, compiled loops, and BibTeX."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, update_wrapper
from pathlib import Path
from typing import Any, ClassVar, Literal, TypeVar, cast

import numpy as np

from bench.contract.objective import Objective
from bench.contract.optimizer import Optimizer, parameter
from bench.contract.typing import Floats
from bench.helpers import read

Function = TypeVar("Function", bound=Callable[..., object])
Handling = Literal["repair", "box"]


def confine(objective: Objective, x: Floats, handling: Handling) -> Floats:
    """Return the (n, d) points ``x`` clipped to the box and, unless ``handling`` is ``"box"``, repaired."""
    x = np.minimum(np.maximum(x, objective.lower), objective.upper)
    return np.ascontiguousarray(objective.repair(x)) if handling == "repair" else x


@dataclass(frozen=True)
class Population(Optimizer):
    """A method that moves a population of ``agents`` and evaluates all of it once a generation.

    Attributes:
        agents: N, the population size; 30 is what the authors of the swarms here use (the thesis uses 300).
        handling: how agents return to the feasible region once all of them have moved. ``"repair"`` clips them to the
            box and then applies the problem's own rule; ``"box"`` only clips them. The resulting points are evaluated,
            and the algorithm goes on from them. The start population is repaired in both cases.
        start: ``"random"``: the start population is ``objective.initial(agents)``.
    """

    start: ClassVar[str] = "random"

    agents: int = parameter(30, minimum=1)
    handling: Handling = "repair"

    def generations(self, objective: Objective) -> int:
        """Return T = ceil(budget / N), the number of generations; the objective cuts the last one short."""
        return -(-objective.budget // self.agents)

    def confine(self, objective: Objective, x: Floats) -> Floats:
        """Return the (n, d) points ``x`` clipped to the box and, unless ``handling`` is ``"box"``, repaired."""
        return confine(objective, x, self.handling)


def works(*keys: str) -> str:
    """Return the BibTeX of the works with these keys in ``optimizers/references.bib``."""
    library = read(Path(__file__).parents[1] / "references.bib")
    return "\n".join(library[key].bibtex for key in keys)


def compiled(function: Function) -> Function:
    """Return ``function`` compiled by numba, with numpy's rules of division.

    numba is imported, and the function compiled or read from numba's cache on disk, when it is first called: importing
    an optimizer, as ``bench list`` does, must not wait for numba. Another compiled function may call it.

    Without ``fastmath``, no sum is reordered: results depend on the seed and not on the width of the CPU's vectors.
    """
    return cast(Function, _Compiled(function))


class _Compiled:
    """A function that numba compiles when it is first needed."""

    def __init__(self, function: Callable[..., object]) -> None:
        update_wrapper(self, function)
        self.function = function

    def __call__(self, *args: object) -> object:
        return self.dispatcher(*args)

    @cached_property
    def dispatcher(self) -> Any:
        from numba import njit

        return njit(self.function, cache=True, error_model="numpy")

    @property
    def _numba_type_(self) -> object:
        """The type of this function for numba where another compiled function calls it."""
        return self.dispatcher._numba_type_
