"""The grasshopper optimisation algorithm (GOA) as its author's code runs it."""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial
from typing import ClassVar, Literal

import numpy as np

from bench.contract.objective import Objective
from bench.contract.optimizer import parameter
from bench.contract.typing import Floats
from optimizers.common.base import Population, compiled, works

C_MAX, C_MIN = 1.0, 0.00004  # (GOA.m)
EPS = 2.0**-52  # (GOA.m: eps)
TILE = 32  # grasshoppers; two tiles of forces fit into the first-level cache


@dataclass(frozen=True)
class GOA(Population):
    """Grasshopper optimisation algorithm: the best point so far, plus forces between all pairs of grasshoppers.

    Example:
        >>> bench.solve("signature-12", GOA(agents=300), budget=60_000, seed=1).fun

    Source: S. Saremi, S. Mirjalili, A. Lewis, Grasshopper Optimisation Algorithm, Advances in Engineering Software
    105, 2017, doi:10.1016/j.advengsoft.2017.01.004; the details follow the author's MATLAB code, GOA.m, which departs
    from the paper: a distance is taken in two coordinates at a time, (1, 2), (3, 4), …, and enters the force as
    2 + D mod 2; with an odd number of variables a dummy one with bounds +-100 is appended, which moves with the others
    and is never evaluated. After the start population nothing is random.

    Its schedule runs over the whole budget: with another budget, a seed gives another course from the first moves on.

    Attributes:
        agents: N, the number of grasshoppers; at least 2, as a single one feels no force.
        handling: see :class:`~optimizers.common.base.Population`.
        variant: ``"code"`` follows GOA.m; ``"full-distance"`` takes the distance over all coordinates at once and needs
            no dummy, as most re-implementations do: a very different algorithm. On five functions (d = 7, 30 agents,
            200 generations, 200 seeds; ``python validation/variants.py``) the median of the final bests is then 8.5e-9
            against 1.9 on the sphere, 4.9e-4 against 1.4 on Ackley's function, 4.2 against 150 on Rosenbrock's, 1.4e3
            against 3.0e3 on a rotated ellipsoid (exact KS, p < 1e-4), and 22 against 20 on Rastrigin's (p = .02).
    """

    bibtex: ClassVar[str] = works("saremi2017")
    code: ClassVar[str] = "written here after the authors' GOA.m"

    agents: int = parameter(30, minimum=2)
    variant: Literal["code", "full-distance"] = "code"

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent."""
        N, d, T = self.agents, objective.dimension, self.generations(objective)
        width = 2 if self.variant == "code" else d
        lower, upper = objective.lower, objective.upper
        x = objective.initial(N)
        f = objective(x)
        if d % width:  # the dummy variable (GOA.m: dim + 1)
            lower, upper = np.append(lower, -100.0), np.append(upper, 100.0)
            x = np.column_stack([x, rng.uniform(-100.0, 100.0, N)])
        best = int(np.argmin(f))
        target, target_fitness = x[best].copy(), f[best]
        for l in range(2, T + 1):  # noqa: E741 - the code's symbol
            c = C_MAX - l * (C_MAX - C_MIN) / T  # (eq. 2.8)
            S = (upper - lower) * c / 2 * social_forces(x.T.copy(), width).T  # (eq. 2.7, the sum over j)
            x = np.minimum(np.maximum(c * S + target, lower), upper)  # (eq. 2.7)
            x[:, :d] = inside = self.confine(objective, x[:, :d])
            f = objective(inside)
            best = int(np.argmin(f))
            if f[best] < target_fitness:
                target, target_fitness = x[best].copy(), f[best]


# s(r) = f exp(-r / l) - exp(-r) with f = 0.5 and l = 1.5 (eq. 2.3) is wanted for r = 2 + D mod 2 only. Its series in
# u = r - 3, |u| <= 1, is exact to 1e-17 at this degree and, unlike exp, vectorised and the same on every machine.
EXP_2, EXP_3 = 0.1353352832366127, 0.049787068367863944  # exp(-3 / l) and exp(-3)
SERIES = tuple((0.5 * EXP_2 * (-1 / 1.5) ** n - EXP_3 * (-1) ** n) / factorial(n) for n in range(18))


@compiled
def social_force(distance: float) -> float:
    """Return s(2 + ``distance`` mod 2) (eq. 2.3)."""
    u = distance - 2 * np.floor(distance / 2) - 1
    s: float = SERIES[17]
    for n in range(16, -1, -1):
        s = s * u + SERIES[n]
    return s


@compiled
def social_forces(x: Floats, width: int) -> Floats:
    """Return the (d, N) sums over j of s(2 + D mod 2) (x_j - x_i) / (D + eps) for (d, N) positions ``x``.

    D is the distance within each group of ``width`` coordinates. A sum takes its terms in the order of j, the term
    j = i, which is zero, included. A pair's force, the costly part, is computed once for both: the forces between two
    tiles of grasshoppers pull the later tile and, mirrored, the earlier one, which by then holds the terms of all tiles
    up to itself. The inner loops are in functions of their own, where the compiler vectorises them.
    """
    d, N = x.shape
    S = np.zeros((d, N))
    forces, mirrored = np.empty((TILE, TILE)), np.empty((TILE, TILE))
    for group in range(0, d, width):
        for early in range(0, N, TILE):
            for late in range(early, N, TILE):
                for k in range(group, group + width):
                    add_squares(forces, x[k, late : late + TILE], x[k, early : early + TILE], k == group)
                to_forces(forces, mirrored, min(TILE, N - early), min(TILE, N - late))
                for k in range(group, group + width):
                    pull(S[k, late : late + TILE], forces, x[k, late : late + TILE], x[k, early : early + TILE])
                if late > early:
                    for k in range(group, group + width):
                        pull(S[k, early : early + TILE], mirrored, x[k, early : early + TILE], x[k, late : late + TILE])
    return S


@compiled
def add_squares(squares: Floats, x: Floats, y: Floats, first: bool) -> None:
    """Add to the (m, n) ``squares`` those of the differences from ``x`` (n,) to ``y`` (m,); the first ones are set."""
    for j in range(len(y)):
        row = squares[j]
        if first:
            for i in range(len(x)):
                row[i] = (y[j] - x[i]) ** 2
        else:
            for i in range(len(x)):
                row[i] += (y[j] - x[i]) ** 2


@compiled
def to_forces(squares: Floats, mirrored: Floats, m: int, n: int) -> None:
    """Replace m rows and n columns of squared distances D^2 by s(2 + D mod 2) / (D + eps), and mirror these."""
    for j in range(m):
        row = squares[j]
        for i in range(n):
            D = np.sqrt(row[i])
            row[i] = social_force(D) / (D + EPS)
        for i in range(n):
            mirrored[i, j] = row[i]


@compiled
def pull(S: Floats, forces: Floats, x: Floats, y: Floats) -> None:
    """Add to the sums ``S`` (n,) the pulls of ``y`` (m,) on ``x`` (n,), one after another, by the (m, n) ``forces``."""
    for j in range(len(y)):
        row = forces[j]
        for i in range(len(x)):
            S[i] += row[i] * (y[j] - x[i])
