"""The problem family ``engineering-welded-beam`` and so on."""

from __future__ import annotations

from bench.helpers.errors import BenchError, nearest
from problems.engineering.design import DesignProblem
from problems.engineering.machines import GEAR_TRAIN, PRESSURE_VESSEL, SPEED_REDUCER, SPRING
from problems.engineering.structures import CANTILEVER_BEAM, I_BEAM, THREE_BAR_TRUSS, TUBULAR_COLUMN, WELDED_BEAM

DESIGNS = {
    "engineering-cantilever-beam": CANTILEVER_BEAM,
    "engineering-gear-train": GEAR_TRAIN,
    "engineering-i-beam": I_BEAM,
    "engineering-pressure-vessel": PRESSURE_VESSEL,
    "engineering-speed-reducer": SPEED_REDUCER,
    "engineering-spring": SPRING,
    "engineering-three-bar-truss": THREE_BAR_TRUSS,
    "engineering-tubular-column": TUBULAR_COLUMN,
    "engineering-welded-beam": WELDED_BEAM,
}


class Family:
    """The family of engineering problems, which the entry point names."""

    def names(self) -> list[str]:
        """Return the names of all design problems."""
        return list(DESIGNS)

    def load(self, name: str, /, **options: object) -> DesignProblem:
        """Return the design problem of that name; raises BenchError where there is none, and for any option."""
        if name not in DESIGNS:
            raise BenchError(f"unknown problem {name!r}{nearest(name, DESIGNS)}")
        for option in options:
            raise BenchError(f"problem {name!r} has no option {option!r}{nearest(option, ())}")
        return DesignProblem(name, DESIGNS[name])


engineering = Family()
