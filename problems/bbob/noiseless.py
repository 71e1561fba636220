"""The families ``bbob``, ``bbob-boxed`` and ``bbob-largescale``: COCO's noiseless suites, computed by its own C code.

Sources: the 24 functions, Hansen, Finck, Ros and Auger 2009, "Real-Parameter Black-Box Optimization Benchmarking 2009:
Noiseless Functions Definitions", INRIA RR-6829; the platform and its package ``coco-experiment``, Hansen, Auger, Ros,
Mersmann, Tusar and Brockhoff 2021, Optimization Methods and Software 36, doi:10.1080/10556788.2020.1808977; the
large-scale suite, Varelas et al. 2020, Applied Soft Computing 97, doi:10.1016/j.asoc.2020.106737.
"""

from __future__ import annotations

from functools import partial

from bench import Problem
from bench.contract.families import Grid, Member
from problems.bbob.coco import BOX, INSTANCES, bbob_function, evaluated, function_of, optimum_of
from problems.common import Suite, SuiteProblem, features_of, group_of

FUNCTIONS = range(1, 25)

TITLES = dict(
    zip(
        (f"f{number:02d}" for number in FUNCTIONS),
        (
            "sphere", "ellipsoid", "Rastrigin", "Büche-Rastrigin", "linear slope", "attractive sector",
            "step ellipsoid", "Rosenbrock", "rotated Rosenbrock", "rotated ellipsoid", "discus", "bent cigar",
            "sharp ridge", "different powers", "rotated Rastrigin", "Weierstrass", "Schaffer F7, conditioning 10",
            "Schaffer F7, conditioning 1000", "Griewank-Rosenbrock F8F2", "Schwefel", "Gallagher, 101 peaks",
            "Gallagher, 21 peaks", "Katsuura", "Lunacek bi-Rastrigin",
        ),
        strict=True,
    )
)  # fmt: skip
"""The names of the functions, as RR-6829 has them."""

GROUPS = {
    "separable": range(1, 6),
    "low or moderate conditioning": range(6, 10),
    "high conditioning, unimodal": range(10, 15),
    "multimodal, adequate global structure": range(15, 20),
    "multimodal, weak global structure": range(20, 25),
}
"""The functions of each of the suite's five groups, as RR-6829 has them."""


def _suite(suite: str, dimensions: tuple[int, ...]) -> Suite:
    grid = Grid(suite, {f"f{number:02d}": dimensions for number in FUNCTIONS}, INSTANCES, TITLES)
    return Suite(grid, partial(_problem, suite))


def _problem(suite: str, name: str, member: Member) -> Problem:
    number, dimension, instance = int(member.function[1:]), member.dimension, member.instance
    if suite == "bbob":
        evaluate = bbob_function(name, number, dimension, instance)
    else:
        evaluate = evaluated(function_of(suite, name, number, dimension, instance))
    features = features_of(suite, member, group_of(number, GROUPS))
    lower, upper = [-BOX] * dimension, [BOX] * dimension
    optimum = optimum_of(number, instance)  # the three suites share it
    return SuiteProblem(evaluate, lower, upper, name=name, optimum=optimum, features=features)


bbob = _suite("bbob", (2, 3, 5, 10, 20, 40))
boxed = _suite("bbob-boxed", (2, 3, 5, 10, 20, 40))
largescale = _suite("bbob-largescale", (20, 40, 80, 160, 320, 640))
