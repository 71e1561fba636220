"""The ant lion optimizer (ALO) as its author's code runs it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from bench.contract.objective import Objective
from bench.contract.optimizer import parameter
from bench.contract.typing import Floats
from optimizers.common.base import Population, compiled, works

Bytes = NDArray[np.uint8]

# The +-1 steps of a random walk are random bits, taken eight at a time. For k = 0..8 and each byte (lowest bit first):
_STEPS = (2 * (np.arange(256) >> np.arange(8)[:, np.newaxis] & 1) - 1).astype(np.int8)
SUM = np.vstack([np.zeros((1, 256), dtype=np.int8), _STEPS.cumsum(axis=0, dtype=np.int8)])  # position after k steps
LOW, HIGH = np.minimum.accumulate(SUM, axis=0), np.maximum.accumulate(SUM, axis=0)  # its extremes up to there


@dataclass(frozen=True)
class ALO(Population):
    """Ant lion optimizer: ants walk at random around an antlion and around the elite; fitter ants replace antlions.

    Example:
        >>> bench.solve("signature-12", ALO(agents=300), budget=60_000, seed=1).fun

    Source: S. Mirjalili, The Ant Lion Optimizer, Advances in Engineering Software 83, 2015,
    doi:10.1016/j.advengsoft.2015.01.010; the details follow the author's MATLAB code, ALO.m, which departs from the
    paper: the ratio I has a ``1 +``; the interval's two ends are each mirrored with probability one half; and the
    fitness that the roulette wheel and the merge see of the antlions **stays that of the initial population**,
    while their positions move on. The roulette weighs with 1/f and is sound for positive objective values only:
    otherwise it takes, like the code, the first entry of the running sum that exceeds its draw, or antlion 1.

    Its schedule runs over the whole budget: with another budget, a seed gives another course from the first moves on.

    Attributes:
        agents: N, the number of ants and of antlions.
        handling: see :class:`~optimizers.common.base.Population`.
        variant: ``"code"`` follows ALO.m; ``"paper"`` refreshes the antlions' fitness every generation (eq. 2.12) and
            is in all else the same. On five functions (d = 7, 30 agents, 200 generations, 200 seeds; ``python
            validation/variants.py``) the median of the final bests is then 1.8e-4 against 4.2e-4 on Ackley's function
            (exact KS, p = 7e-9), 11 against 13 on Rastrigin's (p = .001), 3.1e3 against 2.5e3 on a rotated ellipsoid
            (p = .004), and the same on the sphere (5e-10) and, within the precision of these runs, on Rosenbrock's.
    """

    bibtex: ClassVar[str] = works("mirjalili2015")
    code: ClassVar[str] = "written here after the author's ALO.m"

    agents: int = parameter(30, minimum=2)
    variant: Literal["code", "paper"] = "code"

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent."""
        N, d, T = self.agents, objective.dimension, self.generations(objective)
        antlions = objective.initial(N)
        fitness = objective(antlions)
        order = np.argsort(fitness, kind="stable")
        antlions, fitness = antlions[order], fitness[order]
        elite, elite_fitness = antlions[0].copy(), fitness[0]
        running = wheel(fitness)
        for t in range(2, T + 1):
            I = ratio(t, T)  # noqa: E741 - the paper's symbol
            lower, upper = objective.lower / I, objective.upper / I  # (eqs. 2.10 and 2.11)
            uniforms = rng.random((N, 5))
            words = rng.integers(2**64, size=(N, 2, d, -(-T // 64)), dtype=np.uint64)
            steps = words.astype("<u8", copy=False).view(np.uint8)
            ants = walk_ants(antlions, elite, running, lower, upper, t, T, uniforms, steps)
            ants = self.confine(objective, ants)
            merged = np.concatenate([fitness, objective(ants)])
            order = np.argsort(merged, kind="stable")[:N]
            antlions, merged = np.concatenate([antlions, ants])[order], merged[order]
            if merged[0] < elite_fitness:
                elite, elite_fitness = antlions[0].copy(), merged[0]
            antlions[0], merged[0] = elite, elite_fitness
            if self.variant == "paper":
                fitness = merged  # an antlion takes the position, and the fitness, of the ant it caught (eq. 2.12)
                running = wheel(fitness)


def ratio(t: int, T: int) -> float:
    """Return I, the factor that shrinks the walks' interval in generation ``t`` of ``T``."""
    for share, w in ((0.95, 6), (0.9, 5), (0.75, 4), (0.5, 3), (0.1, 2)):  # (below eq. 2.11)
        if t > share * T:
            return 1 + 10.0**w * t / T  # (the paper has no "1 +")
    return 1.0


def wheel(fitness: Floats) -> Floats:
    """Return the (N,) running sum of the roulette's weights."""
    with np.errstate(all="ignore"):  # f = 0 weighs infinitely much
        return np.cumsum(1 / fitness)


@compiled
def walk_ants(
    antlions: Floats,
    elite: Floats,
    wheel: Floats,
    lower: Floats,
    upper: Floats,
    t: int,
    T: int,
    uniforms: Floats,
    steps: Bytes,
) -> Floats:
    """Return the (N, d) ants of generation ``t``.

    ``lower`` and ``upper`` are the bounds over I; row i of the (N, 5) ``uniforms`` is ant i's draw on the roulette and
    the coins of its two walks for the lower and the upper end; ``steps`` (N, 2, d, at least T / 8) are random bytes.
    """
    N, d = antlions.shape
    ants = np.zeros((N, d))
    above, width = random_walks(steps.reshape(N * 2 * d, -1), t, T)
    for i in range(N):
        chosen = 0  # without a hit: the first
        drawn = uniforms[i, 0] * wheel[-1]
        for j in range(N):
            if wheel[j] > drawn:
                chosen = j
                break
        for walk in range(2):
            down = 1.0 if uniforms[i, 1 + 2 * walk] < 0.5 else -1.0
            up = 1.0 if uniforms[i, 2 + 2 * walk] < 0.5 else -1.0
            for k in range(d):
                antlion = elite[k] if walk else antlions[chosen, k]
                low, high = antlion + down * lower[k], antlion + up * upper[k]  # c (eq. 2.8) and d (eq. 2.9)
                n = (2 * i + walk) * d + k
                ants[i, k] += above[n] * (high - low) / width[n] + low  # (eq. 2.7)
        for k in range(d):
            ants[i, k] /= 2  # (eq. 2.13)
    return ants


@compiled
def random_walks(steps: Bytes, t: int, T: int) -> tuple[Floats, Floats]:
    """Return positions above the minimum of walks of T fair +-1 steps after t - 1 of them (eq. 2.1), and their widths.

    Both are (n,), of n walks; ``steps`` (n, at least T / 8) are their bits.
    """
    n = steps.shape[0]
    above, width = np.empty(n), np.empty(n)
    there, end = (t - 1) >> 3, T >> 3
    for row in range(n):
        x = a = b = 0
        for m in range(there):
            byte = steps[row, m]
            a, b, x = min(a, x + LOW[8, byte]), max(b, x + HIGH[8, byte]), x + SUM[8, byte]
        X = x + SUM[(t - 1) & 7, steps[row, there]]
        for m in range(there, end):
            byte = steps[row, m]
            a, b, x = min(a, x + LOW[8, byte]), max(b, x + HIGH[8, byte]), x + SUM[8, byte]
        byte = steps[row, (T - 1) >> 3]  # where T is no multiple of eight, its first bits are the last steps
        a, b = min(a, x + LOW[T & 7, byte]), max(b, x + HIGH[T & 7, byte])
        above[row], width[row] = X - a, b - a
    return above, width
