"""A constrained design problem: objective, constraints, and the best-known design."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from bench import Problem, load_problem
from bench.contract.typing import Floats

Columns = Sequence[Floats]
"""The d columns of (n, d) points, (n,) each."""


@dataclass(frozen=True)
class Design:
    """The published facts on a design problem.

    Formulas take the columns of (n, d) points. They use products instead of powers: products give the same bits for one
    point as for many, a library's power may not.

    Attributes:
        objective: maps the columns to (n,) values.
        constraints: maps the columns to m arrays (n,), each at most 0 where a point is feasible.
        box: the range of each variable, by its name.
        best: the best-known design.
        steps: the spacing of each variable's values, 0 for a continuous one; by default all are continuous.
    """

    objective: Callable[[Columns], Floats]
    constraints: Callable[[Columns], Sequence[Floats]]
    box: dict[str, tuple[float, float]]
    best: tuple[float, ...]
    steps: tuple[float, ...] = ()


class DesignProblem(Problem):
    """A constrained design problem.

    ``evaluate`` is the plain objective: **it knows nothing of the constraints**, which :meth:`violations` returns, so
    points outside the constraints may have lower values than ``optimum``; a study handles the constraints. A variable
    of discrete values is rounded to the nearest of them wherever a point is used.

    ``optimum_point`` is the best-known design, which is feasible; ``optimum`` is its objective.
    """

    optimum_source = "the best known design"

    def __init__(self, name: str, design: Design) -> None:
        self.name = name
        self.variables = tuple(design.box)
        self.lower, self.upper = np.array(list(design.box.values()), dtype=np.float64).T.copy()
        self.steps = np.array(design.steps or np.zeros(self.dimension))
        self.integer = self.steps == 1 if (self.steps == 1).any() else None
        self.optimum_point = np.array(design.best)
        self._design = design
        self.optimum = float(self.evaluate(self.optimum_point[None])[0])
        kind = "constrained, mixed-integer" if self.steps.any() else "constrained"
        self.features = {"suite": "engineering", "function": name.partition("-")[2], "group": kind}

    def __reduce__(self) -> tuple[Callable[[str], Problem], tuple[str]]:
        return load_problem, (self.name,)

    def evaluate(self, x: Floats) -> Floats:
        """Return the (n,) objective values of the (n, d) designs ``x``, feasible or not."""
        return self._design.objective(list(self.rounded(x).T))

    def violations(self, x: Floats) -> Floats:
        """Return the (n, m) constraints of the (n, d) designs ``x``; a design is feasible where all are at most 0."""
        values = self._design.constraints(list(self.rounded(x).T))
        return np.stack(values, axis=1) if values else np.empty((len(x), 0))

    def repair(self, x: Floats) -> Floats:
        """Return the designs in the box nearest to the (n, d) ``x``, rounded; they may violate constraints."""
        return self.rounded(super().repair(x))

    def rounded(self, x: Floats) -> Floats:
        """Return the (n, d) designs ``x`` with each discrete variable at its nearest value."""
        steps = np.where(self.steps > 0, self.steps, 1.0)
        return np.where(self.steps > 0, np.round(x / steps) * steps, x)
