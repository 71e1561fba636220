"""Design problems of machine elements: pressure vessel, spring, speed reducer, gear train."""

import math

import numpy as np

from bench.contract.typing import Floats
from problems.engineering.design import Columns, Design

INCH_16 = 0.0625  # plates come in multiples of a sixteenth of an inch


def _vessel_cost(x: Columns) -> Floats:
    shell, head, radius, length = x
    plates = 0.6224 * shell * radius * length + 1.7781 * head * radius * radius
    return plates + 3.1661 * shell * shell * length + 19.84 * shell * shell * radius


def _vessel_constraints(x: Columns) -> list[Floats]:
    shell, head, radius, length = x
    volume = math.pi * radius * radius * length + 4 / 3 * math.pi * radius * radius * radius
    return [0.0193 * radius - shell, 0.00954 * radius - head, 1_296_000 - volume, length - 240]


RADIUS = 0.8125 / 0.0193  # the shell's thickness is fully used, and the volume is just enough

PRESSURE_VESSEL = Design(
    _vessel_cost,
    _vessel_constraints,
    {"shell": (INCH_16, 99 * INCH_16), "head": (INCH_16, 99 * INCH_16), "radius": (10, 200), "length": (10, 200)},
    (0.8125, 0.4375, RADIUS, (1_296_000 - 4 / 3 * math.pi * RADIUS**3) / (math.pi * RADIUS**2) * (1 + 1e-15)),
    (INCH_16, INCH_16, 0, 0),
)
"""Cost in $ of a vessel for compressed air; lengths in inches, volume of 750 cubic feet.

Sandgren 1990, Journal of Mechanical Design 112(2), doi:10.1115/1.2912596; with these constants Kannan and Kramer 1994,
doi:10.1115/1.2919393. Best known: 6059.714335, such as Gandomi, Yang and Alavi 2013, doi:10.1007/s00366-011-0241-y.
"""


def _spring_weight(x: Columns) -> Floats:
    wire, coil, coils = x
    return (coils + 2) * coil * wire * wire


def _spring_constraints(x: Columns) -> list[Floats]:
    wire, coil, coils = x
    cube = wire * wire * wire
    stress = (4 * coil * coil - wire * coil) / (12_566 * (coil * cube - cube * wire)) + 1 / (5108 * wire * wire) - 1
    return [
        1 - coil * coil * coil * coils / (71_785 * cube * wire),
        stress,
        1 - 140.45 * wire / (coil * coil * coils),
        (wire + coil) / 1.5 - 1,
    ]


SPRING = Design(
    _spring_weight,
    _spring_constraints,
    {"wire": (0.05, 2.0), "coil": (0.25, 1.3), "coils": (2.0, 15.0)},
    (0.051689061151118015, 0.3567177414438711, 11.288965655205548),
)
"""Weight of a tension/compression spring by wire diameter, mean coil diameter and number of active coils.

Belegundu 1982, A Study of Mathematical Programming Methods for Structural Optimization, PhD thesis, University of Iowa;
Arora 1989, Introduction to Optimum Design. Best known: 0.0126652, such as Gandomi, Yang and Alavi 2013.
"""


def _reducer_weight(x: Columns) -> Floats:
    face, module, teeth, between1, between2, shaft1, shaft2 = x
    gears = 0.7854 * face * module * module * (3.3333 * teeth * teeth + 14.9334 * teeth - 43.0934)
    squares, cubes = shaft1 * shaft1 + shaft2 * shaft2, shaft1 * shaft1 * shaft1 + shaft2 * shaft2 * shaft2
    shafts = 0.7854 * (between1 * shaft1 * shaft1 + between2 * shaft2 * shaft2)
    return gears - 1.508 * face * squares + 7.4777 * cubes + shafts


def _reducer_constraints(x: Columns) -> list[Floats]:
    face, module, teeth, between1, between2, shaft1, shaft2 = x
    cube1, cube2 = shaft1 * shaft1 * shaft1, shaft2 * shaft2 * shaft2
    load1, load2 = 745 * between1 / (module * teeth), 745 * between2 / (module * teeth)
    return [
        27 / (face * module * module * teeth) - 1,
        397.5 / (face * module * module * teeth * teeth) - 1,
        1.93 * between1 * between1 * between1 / (module * teeth * cube1 * shaft1) - 1,
        1.93 * between2 * between2 * between2 / (module * teeth * cube2 * shaft2) - 1,
        np.sqrt(load1 * load1 + 16.9e6) / (110 * cube1) - 1,
        np.sqrt(load2 * load2 + 157.5e6) / (85 * cube2) - 1,
        module * teeth / 40 - 1,
        5 * module / face - 1,
        face / (12 * module) - 1,
        (1.5 * shaft1 + 1.9) / between1 - 1,
        (1.1 * shaft2 + 1.9) / between2 - 1,
    ]


SPEED_REDUCER = Design(
    _reducer_weight,
    _reducer_constraints,
    {
        "face": (2.6, 3.6), "module": (0.7, 0.8), "teeth": (17, 28), "between1": (7.3, 8.3), "between2": (7.3, 8.3),
        "shaft1": (2.9, 3.9), "shaft2": (5.0, 5.5),
    },
    (3.5, 0.7, 17, 7.3, 7.715319911478258, 3.3502146660964507, 5.286654464980227),
    (0, 0, 1, 0, 0, 0, 0),
)  # fmt: skip
"""Weight of a speed reducer: face width, module, pinion's teeth, lengths between bearings, and shafts' diameters.

Golinski 1973, Mechanism and Machine Theory 8(4). Best known: 2994.4711, such as
Ray and Liew 2003, IEEE Transactions on Evolutionary Computation 7(4), doi:10.1109/TEVC.2003.814902.
"""


def _gear_error(x: Columns) -> Floats:
    driver1, driver2, driven1, driven2 = x
    error = 1 / 6.931 - driver1 * driver2 / (driven1 * driven2)
    return error * error


GEAR_TRAIN = Design(
    _gear_error,
    lambda _: [],  # none but the box
    {"driver1": (12, 60), "driver2": (12, 60), "driven1": (12, 60), "driven2": (12, 60)},
    (16, 19, 43, 49),
    (1, 1, 1, 1),
)
"""Squared error of a compound gear train's ratio, which should be 1/6.931, by its four numbers of teeth.

Sandgren 1990, Journal of Mechanical Design 112(2), doi:10.1115/1.2912596. Best: 2.700857e-12, found by trying all.
"""
