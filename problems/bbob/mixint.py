"""The family ``bbob-mixint``: bbob with four fifths of the variables whole numbers, by COCO's own C code.

The first fifth of the variables takes 2 values, the others 4, 8 and 16, the last fifth is continuous. Each function is
scaled, so that all are similarly hard. The harness rounds for optimizers that do not know of whole numbers.

Source: Tušar, Brockhoff and Hansen 2019, "Mixed-integer benchmark problems for single- and bi-objective optimization",
GECCO, doi:10.1145/3321707.3321868.
"""

from __future__ import annotations

import numpy as np

from bench import Problem
from bench.contract.families import Grid, Member
from problems.bbob.coco import INSTANCES, evaluated, function_of, optimum_of
from problems.bbob.noiseless import FUNCTIONS, GROUPS, TITLES
from problems.common import Suite, SuiteProblem, features_of, group_of

DIMENSIONS = (5, 10, 20, 40, 80, 160)
SCALES = (
    1, 1e-3, 0.1, 0.1, 1, 0.01, 1, 0.01, 0.01, 1e-3, 0.01, 1e-4,
    0.1, 1, 0.1, 1, 10, 1, 10, 0.1, 1, 1, 10, 0.1,
)  # fmt: skip
"""The factor of each function's values, the optimal one included."""


def _problem(name: str, member: Member) -> Problem:
    number, dimension, instance = int(member.function[1:]), member.dimension, member.instance
    function = function_of("bbob-mixint", name, number, dimension, instance)
    features = features_of("bbob-mixint", member, group_of(number, GROUPS))
    optimum = optimum_of(number, instance) * SCALES[number - 1]
    integer = np.arange(dimension) < function.number_of_integer_variables
    bounds = function.lower_bounds, function.upper_bounds
    return SuiteProblem(evaluated(function), *bounds, name=name, optimum=optimum, features=features, integer=integer)


mixint = Suite(Grid("bbob-mixint", {f"f{n:02d}": DIMENSIONS for n in FUNCTIONS}, INSTANCES, TITLES), _problem)
