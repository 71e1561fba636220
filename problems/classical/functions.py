"""The functions of the family: each sets (n,) ``values`` at (n, d) offsets ``y`` from its optimum, 0 at the optimum.

Written in offsets, a function loses no digits near its optimum. The literature's variable is ``z = y + z*`` with the
optimum ``z*``; a difference of cosines is written as a square of a sine, ``1 - cos(2 a) = 2 sin(a)^2``. Each row is
summed by itself in one order, without fast-math, so that a value depends on its point alone.
"""

import math

import numpy as np

from bench.contract.typing import Floats

SCHWEFEL = 20.51752290994169**2
"""Where ``z sin(sqrt(z))`` is largest in [0, 500], 420.9687…: the square of a root of ``tan(u) = -u/2``."""

STYBLINSKI = -2.903534027771177
"""The smallest root of ``4 z^3 - 32 z + 5``, where ``z^4 - 16 z^2 + 5 z`` is least."""


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


def rosenbrock(y: Floats, values: Floats) -> None:
    """``sum 100 (z_i^2 - z_{i+1})^2 + (1 - z_i)^2``, z* = 1: Rosenbrock 1960, doi:10.1093/comjnl/3.3.175.

    From four dimensions on there is a second minimum (Shang and Qiu 2006, doi:10.1162/evco.2006.14.1.119).
    """
    n, d = y.shape
    for row in range(n):
        total = 0.0
        for i in range(d - 1):
            bend = y[row, i] * (2.0 + y[row, i]) - y[row, i + 1]  # z_i^2 - z_{i+1}
            total += 100.0 * bend**2 + y[row, i] ** 2
        values[row] = total


def rastrigin(y: Floats, values: Floats) -> None:
    """``sum y_i^2 + 10 (1 - cos(2 pi y_i))``.

    Muehlenbein, Schomisch and Born 1991, doi:10.1016/S0167-8191(05)80052-3, after Rastrigin 1974.
    """
    n, d = y.shape
    for row in range(n):
        total = 0.0
        for i in range(d):
            total += y[row, i] ** 2 + 20.0 * math.sin(math.pi * y[row, i]) ** 2
        values[row] = total


def ackley(y: Floats, values: Floats) -> None:
    """``20 + e - 20 exp(-0.2 rms(y)) - exp(mean cos(2 pi y_i))``, rms the root of the mean square.

    Ackley 1987, A Connectionist Machine for Genetic Hillclimbing; in d dimensions Baeck 1996, Evolutionary Algorithms
    in Theory and Practice.
    """
    n, d = y.shape
    for row in range(n):
        square, wave = 0.0, 0.0
        for i in range(d):
            square += y[row, i] ** 2
            wave += math.sin(math.pi * y[row, i]) ** 2
        values[row] = -20.0 * math.expm1(-0.2 * math.sqrt(square / d)) - math.e * math.expm1(-2.0 * wave / d)


def griewank(y: Floats, values: Floats) -> None:
    """``sum y_i^2 / 4000 - prod cos(y_i / sqrt(i)) + 1``: Griewank 1981, doi:10.1007/BF00933356."""
    n, d = y.shape
    for row in range(n):
        square, product = 0.0, 1.0
        for i in range(d):
            square += y[row, i] ** 2
            product *= math.cos(y[row, i] / math.sqrt(i + 1.0))
        values[row] = square / 4000.0 + (1.0 - product)


def levy(y: Floats, values: Floats) -> None:
    """``pi/d (10 sin(pi w_1)^2 + sum_{i<d} (w_i - 1)^2 (1 + 10 sin(pi w_{i+1})^2) + (w_d - 1)^2)``, ``w = 1 + y/4``.

    Levy and Montalvo 1985, doi:10.1137/0906002.
    """
    n, d = y.shape
    for row in range(n):
        total = 10.0 * math.sin(math.pi * y[row, 0] / 4.0) ** 2
        for i in range(d - 1):
            total += (y[row, i] / 4.0) ** 2 * (1.0 + 10.0 * math.sin(math.pi * y[row, i + 1] / 4.0) ** 2)
        values[row] = math.pi / d * (total + (y[row, d - 1] / 4.0) ** 2)


def schwefel_2_26(y: Floats, values: Floats) -> None:
    """``sum g(z*) - g(z_i)`` with ``g(z) = z sin(sqrt(|z|))``, z* = 420.97.

    Schwefel 1981, Numerical Optimization of Computer Models, problem 2.26; beyond 500 it is continued and penalised as
    by Liang, Qu and Suganthan 2013, CEC 2014.
    """
    n, d = y.shape
    best = SCHWEFEL * math.sin(math.sqrt(SCHWEFEL))
    for row in range(n):
        total = 0.0
        for i in range(d):
            z = y[row, i] + SCHWEFEL
            size = abs(z)
            if size <= 500.0:
                g = z * math.sin(math.sqrt(size))
            else:
                inside = 500.0 - size % 500.0
                g = math.copysign(inside, z) * math.sin(math.sqrt(inside)) - (size - 500.0) ** 2 / (1e4 * d)
            total += best - g
        values[row] = total


def salomon(y: Floats, values: Floats) -> None:
    """``1 - cos(2 pi r) + r/10`` with ``r = |y|``: Salomon 1996, doi:10.1016/0303-2647(96)01621-8."""
    n, d = y.shape
    for row in range(n):
        square = 0.0
        for i in range(d):
            square += y[row, i] ** 2
        r = math.sqrt(square)
        values[row] = 2.0 * math.sin(math.pi * r) ** 2 + 0.1 * r


def styblinski_tang(y: Floats, values: Floats) -> None:
    """``1/2 sum z_i^4 - 16 z_i^2 + 5 z_i``, less its least value.

    Styblinski and Tang 1990, doi:10.1016/0893-6080(90)90029-K. The least value is subtracted by factors: each term is
    ``(z - z*)^2 (z^2 + 2 z* z + 3 z*^2 - 16)``.
    """
    n, d = y.shape
    for row in range(n):
        total = 0.0
        for i in range(d):
            z = y[row, i] + STYBLINSKI
            total += 0.5 * y[row, i] ** 2 * (z * (z + 2.0 * STYBLINSKI) + 3.0 * STYBLINSKI**2 - 16.0)
        values[row] = total
