"""The family ``bbob-constrained``: nine bbob functions, each under six sets of constraints, by COCO's own C code.

The optimum lies on constraints that are active there; the study decides what optimizers see of infeasible points
(:mod:`bench.trial.scoring.constraints`). COCO also offers a feasible point to start from; here, an optimizer starts as
it does.

Source: Dufossé and Atamna 2022, "Benchmarking several strategies to update the penalty parameters in AL-CMA-ES on the
bbob-constrained testbed", GECCO workshop; the platform, Hansen, Auger, Ros, Mersmann, Tusar and Brockhoff 2021.
"""

from __future__ import annotations

import numpy as np

from bench import Problem
from bench.contract.families import Grid, Member
from bench.contract.typing import Floats
from problems.bbob.coco import BOX, INSTANCES, evaluated, function_of, optimal_point
from problems.common import Suite, SuiteProblem, features_of

DIMENSIONS = (2, 3, 5, 10, 20, 40)
BASES = (
    "sphere", "ellipsoid", "rotated ellipsoid", "linear slope", "discus", "bent cigar", "different powers",
    "Rastrigin", "rotated Rastrigin",
)  # fmt: skip
"""The objectives: f01 to f06 have the first one, f07 to f12 the second one, and so on."""


def _problem(name: str, member: Member) -> Problem:
    number, dimension = int(member.function[1:]), member.dimension
    function = function_of("bbob-constrained", name, number, dimension, member.instance)
    evaluate = evaluated(function)

    def violations(x: Floats) -> Floats:
        values = np.array([function.constraint(row) for row in x], dtype=np.float64)
        return values.reshape(len(x), function.number_of_constraints)

    features = features_of("bbob-constrained", member, BASES[(number - 1) // 6])
    features["constraints"] = function.number_of_constraints
    best = optimal_point(dimension, number + 10_000 * member.instance)
    optimum = float(evaluate(best[np.newaxis])[0])
    lower, upper = [-BOX] * dimension, [BOX] * dimension
    return SuiteProblem(evaluate, lower, upper, name=name, optimum=optimum, features=features, violations=violations)


TITLES = {f"f{n:02d}": BASES[(n - 1) // 6] for n in range(1, 55)}

constrained = Suite(Grid("bbob-constrained", dict.fromkeys(TITLES, DIMENSIONS), INSTANCES, TITLES), _problem)
