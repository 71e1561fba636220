"""Design problems of structures: welded beam, three-bar truss, cantilever beam, I-beam, tubular column."""

import math

import numpy as np

from bench.contract.typing import Floats
from problems.engineering.design import Columns, Design

LOAD, REACH, YOUNG, SHEAR = 6000.0, 14.0, 30e6, 12e6  # lb, in, psi, psi: of the welded beam


def _beam_cost(x: Columns) -> Floats:
    weld, joint, height, width = x
    return 1.10471 * weld * weld * joint + 0.04811 * height * width * (14 + joint)


def _beam_constraints(x: Columns) -> list[Floats]:
    weld, joint, height, width = x
    arm = (weld + height) / 2
    radius = np.sqrt(joint * joint / 4 + arm * arm)
    primary = LOAD / (math.sqrt(2) * weld * joint)
    inertia = 2 * math.sqrt(2) * weld * joint * (joint * joint / 12 + arm * arm)
    torsion = LOAD * (REACH + joint / 2) * radius / inertia
    shear = np.sqrt(primary * primary + primary * torsion * joint / radius + torsion * torsion)
    bending = 6 * LOAD * REACH / (width * height * height)
    deflection = 4 * LOAD * REACH**3 / (YOUNG * height * height * height * width)
    slenderness = 1 - height / (2 * REACH) * math.sqrt(YOUNG / (4 * SHEAR))
    buckling = 4.013 * YOUNG / (6 * REACH**2) * height * width * width * width * slenderness
    return [
        shear - 13_600,
        bending - 30_000,
        weld - width,
        0.10471 * weld * weld + 0.04811 * height * width * (14 + joint) - 5,
        0.125 - weld,
        deflection - 0.25,
        LOAD - buckling,
    ]


WELDED_BEAM = Design(
    _beam_cost,
    _beam_constraints,
    {"weld": (0.1, 2.0), "joint": (0.1, 10.0), "height": (0.1, 10.0), "width": (0.1, 2.0)},
    (0.20572963978608, 3.4704886656280074, 9.036623910357646, 0.20572963978608),
)
"""Cost of a beam welded to a member: the weld's thickness and length, the bar's height and width, in inches.

Ragsdell and Phillips 1976, Journal of Engineering for Industry 98(3), doi:10.1115/1.3438995; in this form Coello 2000,
Computers in Industry 41(2), doi:10.1016/S0166-3615(99)00046-9. Best known: 1.724852.
"""


def _truss_volume(x: Columns) -> Floats:
    return 100 * (2 * math.sqrt(2) * x[0] + x[1])


def _truss_constraints(x: Columns) -> list[Floats]:
    outer, inner = x
    area = math.sqrt(2) * outer * outer + 2 * outer * inner
    return [
        (math.sqrt(2) * outer + inner) / area * 2 - 2,
        inner / area * 2 - 2,
        1 / (outer + math.sqrt(2) * inner) * 2 - 2,
    ]


OPTIMAL_TRUSS = (
    (3 + math.sqrt(3)) / 6 * (1 + 1e-15),
    1 / math.sqrt(6) * (1 + 1e-15),
)

THREE_BAR_TRUSS = Design(_truss_volume, _truss_constraints, {"outer": (1e-6, 1.0), "inner": (0.0, 1.0)}, OPTIMAL_TRUSS)
"""Volume in cm^3 of a truss of three bars, 100 cm high, under 2 kN, by the cross-sections of the outer and inner bars.

Nowacki 1974, Optimization in Pre-Contract Ship Design; Ray and Saini 2001, Engineering Optimization 33(6),
doi:10.1080/03052150108940941. Best known: 263.8958434, where the outer bars bear all they may. The literature's box
begins at 0, where the stress is infinite.
"""

STIFFNESS = (61.0, 37.0, 19.0, 7.0, 1.0)


def _cantilever_weight(x: Columns) -> Floats:
    return 0.0624 * (x[0] + x[1] + x[2] + x[3] + x[4])


def _cantilever_constraints(x: Columns) -> list[Floats]:
    terms = [weight / (side * side * side) for weight, side in zip(STIFFNESS, x, strict=True)]
    return [terms[0] + terms[1] + terms[2] + terms[3] + terms[4] - 1]


_ROOTS = [weight**0.25 for weight in STIFFNESS]

CANTILEVER_BEAM = Design(
    _cantilever_weight,
    _cantilever_constraints,
    {f"side{i}": (0.01, 100.0) for i in range(1, 6)},
    tuple(root * sum(_ROOTS) ** (1 / 3) * (1 + 1e-15) for root in _ROOTS),
)
"""Weight of a stepped cantilever of five hollow square blocks, by their sides.

Fleury and Braibant 1986, International Journal for Numerical Methods in Engineering 23(3), doi:10.1002/nme.1620230307;
Chickermane and Gea 1996, the same journal 39(5). The optimum is the solution of Lagrange's conditions: sides in
proportion to the fourth roots of the constants, weight 1.3399564.
"""


def _i_beam_deflection(x: Columns) -> Floats:
    height, width, web, flange = x
    clear, gap = height - 2 * flange, height - flange
    inertia = web * clear * clear * clear / 12 + width * flange * flange * flange / 6 + width * flange * gap * gap / 2
    return 5000 / inertia


def _i_beam_constraints(x: Columns) -> list[Floats]:
    height, width, web, flange = x
    clear = height - 2 * flange
    upright = web * clear * clear * clear + 2 * width * flange * (4 * flange * flange + 3 * height * clear)
    sideways = clear * web * web * web + 2 * flange * width * width * width
    return [
        2 * width * flange + web * clear - 300,
        1.8e5 * height / upright + 1.5e4 * width / sideways - 6,
    ]


I_BEAM = Design(
    _i_beam_deflection,
    _i_beam_constraints,
    {"height": (10, 80), "width": (10, 50), "web": (0.9, 5.0), "flange": (0.9, 5.0)},
    (80, 50, 0.9, 228 / 98.2 * (1 - 1e-15)),
)
"""Vertical deflection in cm of an I-beam, by height, width, and the thickness of web and flanges, in cm.

Gold and Krishnamurty 1997, Trade-offs in Robust Engineering Design, ASME DETC. At the best design the
cross-section of 300 cm^2 is fully used: 0.0130741, as in Gandomi, Yang and Alavi 2013, doi:10.1007/s00366-011-0241-y.
"""

FORCE, YIELD, ELASTICITY, COLUMN = 2500.0, 500.0, 0.85e6, 250.0  # kgf, kgf/cm^2, kgf/cm^2, cm: of the column


def _column_cost(x: Columns) -> Floats:
    diameter, thickness = x
    return 9.8 * diameter * thickness + 2 * diameter


def _column_constraints(x: Columns) -> list[Floats]:
    diameter, thickness = x
    squares = diameter * diameter + thickness * thickness
    return [
        FORCE / (math.pi * diameter * thickness * YIELD) - 1,
        8 * FORCE * COLUMN**2 / (math.pi**3 * ELASTICITY * diameter * thickness * squares) - 1,
    ]


TUBULAR_COLUMN = Design(
    _column_cost,
    _column_constraints,
    {"diameter": (2.0, 14.0), "thickness": (0.2, 0.8)},
    (5.4511562342548645, 0.29196547714367804),
)
"""Cost of a tubular column under compression, by mean diameter and thickness, in cm.

Rao 1996, Engineering Optimization: Theory and Practice; Hsu and Liu 2007, Engineering Optimization 39(6), 679-700.
At the best design both stress limits are reached: 26.4995.
"""
