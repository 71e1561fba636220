"""The handling of constraints: what an optimizer sees of infeasible points.

It depends on the point's total violation G(x) = Σ max(0, g_i(x)):

================= ===================================================================================================
``death``         +inf
``penalty``       f(x) + R G(x) with R = 10⁶, a static penalty
``lexicographic`` B (1 + G(x)) with B = 10¹⁰⁰; a feasible value of B or more appears as the float below B
``repair``        the value of the repaired point, in whose place it is recorded; +inf where that is infeasible too
================= ===================================================================================================

``lexicographic`` orders points as Deb (2000): feasible before infeasible, feasible ones by f, infeasible ones by G.
One float suffices: B (1 + G) >= B exceeds every feasible value shown, and does not decrease with G, which rounding
keeps; two violations whose difference is below 2.2e-16 (1 + G) are equal. B is a power at which squares, sums
and differences of values do not overflow yet, for optimizers that calculate with them. A point whose violation is NaN
or infinite is +inf in every handling, and so is a feasible point whose objective is NaN or +inf.

References:
    Coello Coello (2002), Theoretical and numerical constraint-handling techniques used with evolutionary algorithms: a
    survey of the state of the art, Comput. Methods Appl. Mech. Eng. 191:1245-1287 (death, static penalties, repair).
    Deb (2000), An efficient constraint handling method for genetic algorithms, the same journal 186:311-338.
"""

from __future__ import annotations

import numpy as np

from bench.contract.typing import Floats
from bench.helpers.errors import BenchError, nearest

HANDLINGS = ("death", "penalty", "lexicographic", "repair")
DEFAULT = "lexicographic"  # it needs no coefficient, and leads an optimizer from infeasible points, unlike death
COEFFICIENT = 1e6  # R
BARRIER = 1e100  # B


def visible_values(handling: str, values: Floats, total: Floats) -> Floats:
    """Return the (n,) values that an optimizer sees of n points under one of the ``HANDLINGS``.

    Args:
        handling: with ``repair``, values and violations are those of the repaired points.
        values: (n,) the objective's values, at feasible and infeasible points.
        total: (n,) the total violations, 0 where a point is feasible.
    """
    feasible, values = total <= 0, np.where(np.isnan(values), np.inf, values)
    if handling == "penalty":
        with np.errstate(over="ignore", invalid="ignore"):
            penalised = values + COEFFICIENT * total
        return np.where(feasible, values, np.where(np.isnan(penalised), np.inf, penalised))
    if handling == "lexicographic":
        below = np.where(np.isfinite(values), np.minimum(values, np.nextafter(BARRIER, 0)), values)
        with np.errstate(over="ignore"):
            return np.where(feasible, below, BARRIER * (1 + total))
    return np.where(feasible, values, np.inf)


def read_handling(handling: object, what: str = "'constraints'") -> str:
    """Return the handling; raises BenchError for an unknown one, naming it ``what``."""
    if handling not in HANDLINGS:
        hint = nearest(handling, HANDLINGS) if isinstance(handling, str) else ""
        raise BenchError(f"{what} must be one of {', '.join(HANDLINGS)}, not {handling!r}{hint}")
    return str(handling)
