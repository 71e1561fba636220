"""Unimodal functions: each sets (n,) ``values`` at (n, d) offsets ``y`` from its optimum, 0 at the optimum itself.

Written in offsets, a function loses no digits near its optimum. Each row is summed by itself in one order, without
fast-math, so that a value depends on its point alone.
"""

import math

import numpy as np

from bench.contract.typing import Floats


def sphere(y: Floats, values: Floats) -> None:
    """``sum y_i^2``: De Jong 1975, An Analysis of the Behavior of a Class of Genetic Adaptive Systems, F1."""
    n, d = y.shape
    for row in range(n):
        total = 0.0
        for i in range(d):
            total += y[row, i] ** 2
        values[row] = total


def ellipsoid(y: Floats, values: Floats) -> None:
    """``sum 10^(6 (i-1)/(d-1)) y_i^2``: Hansen and Ostermeier 2001, doi:10.1162/106365601750190398."""
    n, d = y.shape
    weights = 10.0 ** (6.0 * np.arange(d) / (d - 1))
    for row in range(n):
        total = 0.0
        for i in range(d):
            total += weights[i] * y[row, i] ** 2
        values[row] = total


def cigar(y: Floats, values: Floats) -> None:
    """``y_1^2 + 10^6 sum_{i>1} y_i^2``: Hansen and Ostermeier 2001, doi:10.1162/106365601750190398."""
    n, d = y.shape
    for row in range(n):
        total = 0.0
        for i in range(1, d):
            total += y[row, i] ** 2
        values[row] = y[row, 0] ** 2 + 1e6 * total


def discus(y: Floats, values: Floats) -> None:
    """``10^6 y_1^2 + sum_{i>1} y_i^2``: Hansen and Ostermeier 2001, doi:10.1162/106365601750190398."""
    n, d = y.shape
    for row in range(n):
        total = 0.0
        for i in range(1, d):
            total += y[row, i] ** 2
        values[row] = 1e6 * y[row, 0] ** 2 + total


def different_powers(y: Floats, values: Floats) -> None:
    """``sum |y_i|^(2 + 10 (i-1)/(d-1))``: Hansen and Ostermeier 2001, doi:10.1162/106365601750190398."""
    n, d = y.shape
    for row in range(n):
        total = 0.0
        for i in range(d):
            total += abs(y[row, i]) ** (2.0 + 10.0 * i / (d - 1))
        values[row] = total


def sharp_ridge(y: Floats, values: Floats) -> None:
    """``y_1^2 + 100 (sum_{i>1} y_i^2)^(1/2)``: Hansen, Finck, Ros and Auger 2009, INRIA RR-6829, f13."""
    n, d = y.shape
    for row in range(n):
        total = 0.0
        for i in range(1, d):
            total += y[row, i] ** 2
        values[row] = y[row, 0] ** 2 + 100.0 * math.sqrt(total)


def step(y: Floats, values: Floats) -> None:
    """``sum floor(y_i + 1/2)^2``: Yao, Liu and Lin 1999, doi:10.1109/4235.771163, f6; the optimum is a plateau."""
    n, d = y.shape
    for row in range(n):
        total = 0.0
        for i in range(d):
            total += math.floor(y[row, i] + 0.5) ** 2
        values[row] = total


def schwefel_1_2(y: Floats, values: Floats) -> None:
    """``sum_i (sum_{j<=i} y_j)^2``: Schwefel 1981, Numerical Optimization of Computer Models, problem 1.2."""
    n, d = y.shape
    for row in range(n):
        total, partial = 0.0, 0.0
        for i in range(d):
            partial += y[row, i]
            total += partial**2
        values[row] = total


def schwefel_2_22(y: Floats, values: Floats) -> None:
    """``sum |y_i| + prod |y_i|``: Schwefel 1981, Numerical Optimization of Computer Models, problem 2.22."""
    n, d = y.shape
    for row in range(n):
        total, product = 0.0, 1.0
        for i in range(d):
            total += abs(y[row, i])
            product *= abs(y[row, i])
        values[row] = total + product


def zakharov(y: Floats, values: Floats) -> None:
    """``sum y_i^2 + s^2 + s^4`` with ``s = sum i y_i / 2``: Jamil and Yang 2013, doi:10.1504/IJMMNO.2013.055204."""
    n, d = y.shape
    for row in range(n):
        total, s = 0.0, 0.0
        for i in range(d):
            total += y[row, i] ** 2
            s += 0.5 * (i + 1) * y[row, i]
        values[row] = total + s**2 + s**4
