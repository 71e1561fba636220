"""The family ``bbob-noisy``: 30 functions of bbob under noise, f101 to f130.

Each is one of eight bbob functions under one of three models of noise, moderate or severe. An optimizer sees values
with noise, drawn from the trial's own stream; the value without noise is what counts (:mod:`bench.trial.scoring`).

Source: Hansen, Finck, Ros and Auger 2009, "Real-Parameter Black-Box Optimization Benchmarking 2009: Noisy Functions
Definitions", INRIA RR-6869. The functions without noise are computed by COCO's own C code (``coco-experiment``), except
f116 to f118: their ellipsoid has a condition number of 10⁴ instead of bbob's 10⁶, and is computed here. The noise is
written here, because COCO's package repeats the same noise in every run. Outside the box, where COCO adds a penalty,
the harness shows +inf.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from bench import Problem
from bench.contract.families import Grid, Member
from bench.contract.typing import Floats
from problems.bbob import noiseless
from problems.bbob.coco import BOX, INSTANCES, bbob_function, optimal_point, optimum_of, rotation
from problems.common import Suite, SuiteProblem, features_of, group_of

DIMENSIONS = (2, 3, 5, 10, 20, 40)

Noise = Callable[[Floats, np.random.Generator], Floats]

# f104 to f106 are Rosenbrock's function (f08) under moderate noise: a row is the first of three functions, one for each
# model of noise, the function of bbob, and whether the noise is severe.
_ROWS = (
    (101, 1, False), (104, 8, False), (107, 1, True), (110, 8, True), (113, 7, True), (116, 10, True),
    (119, 14, True), (122, 17, True), (125, 19, True), (128, 21, True),
)  # fmt: skip
BASES = {first + model: base for first, base, _ in _ROWS for model in range(3)}
"""The number of the bbob function under the noise, by the number of the noisy one."""

GROUPS = {
    "moderate noise": range(101, 107),
    "severe noise": range(107, 122),
    "severe noise, multimodal": range(122, 131),
}
"""The functions of each of the suite's three groups."""

TINY = 1e-99  # epsilon of the definition
PRECISION = 1e-8  # below this distance from the optimum there is no noise
RAISED = 1.01e-8  # added to every noisy value


def gaussian(f: Floats, rng: np.random.Generator, beta: float) -> Floats:
    """Return f exp(beta N), N standard normal, for (n,) differences f from the optimum."""
    noisy: Floats = f * np.exp(beta * rng.standard_normal(len(f)))
    return noisy


def uniform(f: Floats, rng: np.random.Generator, alpha: float, beta: float) -> Floats:
    """Return f U^beta max(1, (10⁹ / (f + epsilon))^(alpha V)), U and V uniform from 0 to 1."""
    u, v = rng.random((2, len(f)))
    noisy: Floats = f * u**beta * np.maximum(1, (1e9 / (f + TINY)) ** (alpha * v))
    return noisy


def cauchy(f: Floats, rng: np.random.Generator, alpha: float, p: float) -> Floats:
    """Return f + alpha max(0, 1000 + C), C from Cauchy's distribution with the probability p, else 0."""
    struck = rng.random(len(f)) < p
    one, other = rng.standard_normal((2, len(f)))
    noisy: Floats = f + alpha * np.maximum(0, 1000 + struck * one / (np.abs(other) + TINY))
    return noisy


def noise_of(number: int, dimension: int) -> Noise:
    """Return the noise of a function by its number: it maps (n,) differences from the optimum to noisy ones."""
    severe = number >= 107
    scale = 1.0 if severe else 0.01
    models: tuple[Noise, ...] = (
        partial(gaussian, beta=scale),
        partial(uniform, alpha=scale * (0.49 + 1 / dimension), beta=scale),
        partial(cauchy, alpha=scale, p=0.2 if severe else 0.05),
    )
    return models[(number - 101) % 3]


def oscillated(x: Floats) -> Floats:
    """Return T_osz(x), which makes a function smoothly irregular (RR-6829, section 0.2)."""
    with np.errstate(divide="ignore"):
        size = np.log(np.abs(x))
    first, second = np.where(x > 0, 10, 5.5), np.where(x > 0, 7.9, 3.1)
    with np.errstate(invalid="ignore"):
        waves = np.sin(first * size) + np.sin(second * size)
    return np.where(x == 0, 0.0, np.sign(x) * np.exp(size + 0.049 * waves))


def ellipsoid(dimension: int, instance: int, condition: float) -> Callable[[Floats], Floats]:
    """Return bbob's rotated ellipsoid (f10) of another condition number, less its optimal value."""
    seed = 10 + 10_000 * instance
    turn, centre = rotation(dimension, seed + 1_000_000), optimal_point(dimension, seed)
    axes = condition ** (np.arange(dimension) / (dimension - 1))

    def evaluate(x: Floats) -> Floats:
        # A product of matrices would round a point otherwise alone than among others.
        z = oscillated(((x - centre)[:, np.newaxis, :] * turn).sum(axis=2))
        values: Floats = (axes * z * z).sum(axis=1)
        return values

    return evaluate


def _above(name: str, base: int, dimension: int, instance: int, optimum: float) -> Callable[[Floats], Floats]:
    """Return the function under the noise less its optimal value."""
    if base == 10:
        return ellipsoid(dimension, instance, 1e4)
    evaluate = bbob_function(name, base, dimension, instance)
    divisor = 10.0 if base == 19 else 1.0  # f19 is ten times the noisy suite's Griewank-Rosenbrock function
    return lambda x: (evaluate(x) - optimum) / divisor


def _problem(name: str, member: Member) -> Problem:
    number, dimension, instance = int(member.function[1:]), member.dimension, member.instance
    base = BASES[number]
    optimum, noise = optimum_of(base, instance), noise_of(number, dimension)
    above = _above(name, base, dimension, instance, optimum)

    def noiseless(x: Floats) -> Floats:
        return above(x) + optimum

    def observed(x: Floats, rng: np.random.Generator) -> Floats:
        f = np.maximum(above(x), 0.0)  # rounding
        return np.where(f < PRECISION, f, noise(f, rng) + RAISED) + optimum

    features = features_of("bbob-noisy", member, group_of(number, GROUPS))
    lower, upper = [-BOX] * dimension, [BOX] * dimension
    return SuiteProblem(observed, lower, upper, name=name, optimum=optimum, features=features, noiseless=noiseless)


TITLES = {f"f{number}": noiseless.TITLES[f"f{base:02d}"] for number, base in BASES.items()}

noisy = Suite(Grid("bbob-noisy", dict.fromkeys(TITLES, DIMENSIONS), INSTANCES, TITLES), _problem)
