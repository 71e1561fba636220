"""Bring points back to the feasible region before they are evaluated."""

from __future__ import annotations

from typing import Literal

import numpy as np

from bench.objective import Objective
from bench.problem import Floats

Handling = Literal["repair", "box"]


def confine(objective: Objective, x: Floats, handling: Handling) -> Floats:
    """Return the (n, d) points ``x`` clipped to the box and, unless ``handling`` is ``"box"``, repaired."""
    x = np.minimum(np.maximum(x, objective.lower), objective.upper)
    return np.ascontiguousarray(objective.repair(x)) if handling == "repair" else x
