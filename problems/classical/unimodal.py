"""Unimodal functions, to be compiled: each writes the value of the (d,) offset ``y`` from its optimum, 0 there.

Written in offsets, a function loses no digits near its optimum. The loops fix the order of a sum, which fast-math would
change. ``value`` is (1,), as :func:`problems.classical.instance.over_points` needs it.
"""

import math

from bench.typing import Floats


def sphere(y: Floats, value: Floats) -> None:
    """``sum y_i^2``: De Jong 1975, An Analysis of the Behavior of a Class of Genetic Adaptive Systems, F1."""
    total = 0.0
    for i in range(len(y)):
        total += y[i] ** 2
    value[0] = total


def ellipsoid(y: Floats, value: Floats) -> None:
    """``sum 10^(6 (i-1)/(d-1)) y_i^2``: Hansen and Ostermeier 2001, doi:10.1162/106365601750190398."""
    d = len(y)
    total = 0.0
    for i in range(d):
        total += 10.0 ** (6.0 * i / (d - 1)) * y[i] ** 2
    value[0] = total


def cigar(y: Floats, value: Floats) -> None:
    """``y_1^2 + 10^6 sum_{i>1} y_i^2``: Hansen and Ostermeier 2001, doi:10.1162/106365601750190398."""
    total = 0.0
    for i in range(1, len(y)):
        total += y[i] ** 2
    value[0] = y[0] ** 2 + 1e6 * total


def discus(y: Floats, value: Floats) -> None:
    """``10^6 y_1^2 + sum_{i>1} y_i^2``: Hansen and Ostermeier 2001, doi:10.1162/106365601750190398."""
    total = 0.0
    for i in range(1, len(y)):
        total += y[i] ** 2
    value[0] = 1e6 * y[0] ** 2 + total


def different_powers(y: Floats, value: Floats) -> None:
    """``sum |y_i|^(2 + 10 (i-1)/(d-1))``: Hansen and Ostermeier 2001, doi:10.1162/106365601750190398."""
    d = len(y)
    total = 0.0
    for i in range(d):
        total += abs(y[i]) ** (2.0 + 10.0 * i / (d - 1))
    value[0] = total


def sharp_ridge(y: Floats, value: Floats) -> None:
    """``y_1^2 + 100 (sum_{i>1} y_i^2)^(1/2)``: Hansen, Finck, Ros and Auger 2009, INRIA RR-6829, f13."""
    total = 0.0
    for i in range(1, len(y)):
        total += y[i] ** 2
    value[0] = y[0] ** 2 + 100.0 * math.sqrt(total)


def step(y: Floats, value: Floats) -> None:
    """``sum floor(y_i + 1/2)^2``: Yao, Liu and Lin 1999, doi:10.1109/4235.771163, f6; the optimum is a plateau."""
    total = 0.0
    for i in range(len(y)):
        total += math.floor(y[i] + 0.5) ** 2
    value[0] = total


def schwefel_1_2(y: Floats, value: Floats) -> None:
    """``sum_i (sum_{j<=i} y_j)^2``: Schwefel 1981, Numerical Optimization of Computer Models, problem 1.2."""
    total, partial = 0.0, 0.0
    for i in range(len(y)):
        partial += y[i]
        total += partial**2
    value[0] = total


def schwefel_2_22(y: Floats, value: Floats) -> None:
    """``sum |y_i| + prod |y_i|``: Schwefel 1981, Numerical Optimization of Computer Models, problem 2.22."""
    total, product = 0.0, 1.0
    for i in range(len(y)):
        total += abs(y[i])
        product *= abs(y[i])
    value[0] = total + product


def zakharov(y: Floats, value: Floats) -> None:
    """``sum y_i^2 + s^2 + s^4`` with ``s = sum i y_i / 2``: Jamil and Yang 2013, doi:10.1504/IJMMNO.2013.055204."""
    total, s = 0.0, 0.0
    for i in range(len(y)):
        total += y[i] ** 2
        s += 0.5 * (i + 1) * y[i]
    value[0] = total + s**2 + s**4
