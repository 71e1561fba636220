"""The dragonfly algorithm (DA) as its author's code runs it."""

from __future__ import annotations

from dataclasses import dataclass
from math import gamma, pi, sin
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from bench.contract.objective import Objective
from bench.contract.optimizer import parameter
from bench.contract.typing import Floats
from optimizers.common.base import Population, compiled, works

Indices = NDArray[np.uint64]  # unsigned: compiled code then asks of none whether it counts from the end

BETA = 1.5  # (below eq. 3.9)
SIGMA = gamma(1 + BETA) * sin(pi * BETA / 2) / (gamma((1 + BETA) / 2) * BETA * 2 ** ((BETA - 1) / 2))  # (eq. 3.10)
SIGMA **= 1 / BETA  # (eq. 3.10)


@dataclass(frozen=True)
class DA(Population):
    """Dragonfly algorithm: separation, alignment and cohesion within a growing radius, food and enemy.

    Example:
        >>> bench.solve("signature-12", DA(agents=300), budget=60_000, seed=1).fun

    Source: S. Mirjalili, Dragonfly algorithm, Neural Computing and Applications 27, 2016,
    doi:10.1007/s00521-015-1920-1; the details follow the author's MATLAB code, DA.m. The paper leaves out that the
    radius is compared in each coordinate and neighbours differ in every one; that the dragonflies move **in place**, so
    that a later one sees its neighbours' new positions; that a dragonfly far from the food follows its neighbours with
    fresh random weights, and flies a Lévy flight, relative to the origin, only if it has fewer than two.

    Its schedule runs over the whole budget: with another budget, a seed gives another course from the first moves on.

    Attributes:
        agents: N, the number of dragonflies; at least 3, so that one can have the two neighbours of a swarm.
        handling: see :class:`~optimizers.common.base.Population`. Each dragonfly is clipped as it moves; all are
            repaired afterwards.
    """

    bibtex: ClassVar[str] = works("mirjalili2016")
    code: ClassVar[str] = "written here after the author's DA.m"

    agents: int = parameter(30, minimum=3)

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent."""
        N, d, T = self.agents, objective.dimension, self.generations(objective)
        lower, upper = objective.lower, objective.upper
        span = upper - lower
        food, food_fitness = np.zeros(d), np.inf  # (DA.m: zeros, inf)
        enemy, enemy_fitness = np.zeros(d), -np.inf  # (DA.m: zeros, -inf)
        x = np.ascontiguousarray(objective.initial(N))
        v = (lower + span * rng.random((N, d))).T.copy()  # the steps start like positions (DA.m)
        for t in range(1, T + 1):
            fitness = objective(x)
            best = int(np.argmin(fitness))
            if fitness[best] < food_fitness:
                food, food_fitness = x[best].copy(), fitness[best]
            inside = np.flatnonzero(((lower < x) & (x < upper)).all(axis=1))  # strictly (DA.m)
            if len(inside) and fitness[worst := inside[np.argmax(fitness[inside])]] > enemy_fitness:
                enemy, enemy_fitness = x[worst].copy(), fitness[worst]
            r = span / 4 + span * (t / T) * 2  # the neighbourhood's radius (DA.m)
            w = 0.9 - t * ((0.9 - 0.4) / T)  # inertia (DA.m)
            m = max(0.0, 0.1 - t * (0.1 / (T / 2)))  # (DA.m: my_c)
            s, a, c = 2 * m * rng.random(3)  # separation, alignment, cohesion (DA.m)
            f, e = 2 * rng.random(), m  # food, enemy (DA.m)
            weights = np.array([s, a, c, f, e, w])
            uniforms, normals = rng.random((N, d, 3)), rng.standard_normal((N, d, 2))
            moved = x.T.copy()
            fly(moved, v, food, enemy, r, weights, lower, upper, uniforms, normals)
            x = self.confine(objective, moved.T.copy())


@compiled
def fly(
    x: Floats,
    v: Floats,
    food: Floats,
    enemy: Floats,
    r: Floats,
    weights: Floats,
    lower: Floats,
    upper: Floats,
    uniforms: Floats,
    normals: Floats,
) -> None:
    """Move the dragonflies in place, one after another: positions ``x`` and steps ``v``, both (d, N).

    ``weights`` are s, a, c, f, e and w; ``uniforms`` (N, d, 3) weigh alignment, cohesion and separation far from the
    food; ``normals`` (N, d, 2) are u and v of the Lévy flight.
    """
    s, a, c, f, e, w = weights
    d, N = x.shape
    near, neighbours = np.empty(N), np.empty(N, dtype=np.uint64)
    S, A, C = np.zeros(d), np.empty(d), np.zeros(d)
    for i in range(N):
        far, threatened = False, True
        for k in range(d):
            far |= abs(x[k, i] - food[k]) > r[k]
            threatened &= abs(x[k, i] - enemy[k]) <= r[k]
        social = far or s > 0 or a > 0 or c > 0  # in a run's second half no time is spent on neighbours
        count = find_neighbours(x, i, r, near, neighbours) if social else 0
        swarm = count > 1
        for k in range(d):
            S[k], A[k], C[k] = 0.0, v[k, i], 0.0
            if swarm:
                apart, along = 0.0, 0.0
                for j in neighbours[:count]:
                    apart += x[k, j] - x[k, i]
                    along += v[k, j]
                S[k] = -apart  # (eq. 3.1)
                A[k] = along / count  # (eq. 3.2)
                C[k] = apart / count  # (eq. 3.3)
        for k in range(d):
            if far and not swarm:
                levy = 0.01 * normals[i, k, 0] * SIGMA / abs(normals[i, k, 1]) ** (1 / BETA)  # (eq. 3.9)
                v[k, i] = 0.0
                x[k, i] += levy * x[k, i]  # (eq. 3.8)
            else:
                if far:
                    step = uniforms[i, k, 0] * A[k] + uniforms[i, k, 1] * C[k] + uniforms[i, k, 2] * S[k]  # (DA.m)
                else:
                    F = food[k] - x[k, i]  # (eq. 3.4)
                    E = enemy[k] + x[k, i] if threatened else 0.0  # (eq. 3.5)
                    step = s * S[k] + a * A[k] + c * C[k] + f * F + e * E  # (eq. 3.6)
                longest = (upper[k] - lower[k]) / 10  # (DA.m: Delta_max)
                v[k, i] = min(max(step + w * v[k, i], -longest), longest)  # (eq. 3.6)
                x[k, i] += v[k, i]  # (eq. 3.7)
            x[k, i] = min(max(x[k, i], lower[k]), upper[k])


@compiled
def find_neighbours(x: Floats, i: int, r: Floats, near: Floats, neighbours: Indices) -> int:
    """Return the number of neighbours of ``i``; write their increasing indices to the start of ``neighbours`` (N,).

    A neighbour is at most ``r`` away in every coordinate and equal in none, which excludes ``i`` itself. ``near`` (N,)
    is room for marks.
    """
    d, N = x.shape
    near[:] = 1.0
    for k in range(d):
        row, here, radius = x[k], x[k, i], r[k]
        for j in range(N):
            distance = abs(row[j] - here)
            near[j] = near[j] if (distance > 0) & (distance <= radius) else 0.0  # no early exit: it is vectorised
    count = 0
    for j in range(N):
        neighbours[count] = j  # stays if it is one; without a branch, as no CPU would predict it
        count += near[j] > 0
    return count
