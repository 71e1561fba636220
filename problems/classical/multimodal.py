"""Multimodal functions: each sets (n,) ``values`` at (n, d) offsets ``y`` from its optimum, 0 at the optimum itself.

The literature's variable is ``z = y + z*`` with the optimum ``z*``; a difference of cosines is written as a square of a
sine, ``1 - cos(2 a) = 2 sin(a)^2``, so that no digits are lost near the optimum. Each row is summed by itself in one
order, without fast-math, so that a value depends on its point alone.
"""

import math

from bench.contract.typing import Floats

SCHWEFEL = 20.51752290994169**2
"""Where ``z sin(sqrt(z))`` is largest in [0, 500], 420.9687…: the square of a root of ``tan(u) = -u/2``."""

STYBLINSKI = -2.903534027771177
"""The smallest root of ``4 z^3 - 32 z + 5``, where ``z^4 - 16 z^2 + 5 z`` is least."""


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


def weierstrass(y: Floats, values: Floats) -> None:
    """``sum_i sum_{k=0..20} 0.5^k (1 - cos(2 pi 3^k y_i))``: Suganthan et al. 2005, CEC 2005, F11."""
    n, d = y.shape
    for row in range(n):
        total = 0.0
        for i in range(d):
            weight, frequency = 2.0, 1.0
            for _ in range(21):
                turns = frequency * y[row, i]
                turns -= math.floor(turns + 0.5)  # sines of small numbers are faster
                total += weight * math.sin(math.pi * turns) ** 2
                weight *= 0.5
                frequency *= 3.0
        values[row] = total


def katsuura(y: Floats, values: Floats) -> None:
    """``10/d^2 (prod_i (1 + i sum_{j=1..32} |2^j y_i - round(2^j y_i)| / 2^j)^(10/d^1.2) - 1)``.

    Katsuura 1991, American Mathematical Monthly 98(5), as Liang, Qu and Suganthan 2013, CEC 2014, give it.
    """
    n, d = y.shape
    for row in range(n):
        product = 1.0
        for i in range(d):
            total, scale = 0.0, 1.0
            for _ in range(32):
                scale *= 2.0
                total += abs(scale * y[row, i] - math.floor(scale * y[row, i] + 0.5)) / scale
            product *= (1.0 + (i + 1) * total) ** (10.0 / d**1.2)
        values[row] = 10.0 / d**2 * (product - 1.0)


def salomon(y: Floats, values: Floats) -> None:
    """``1 - cos(2 pi r) + r/10`` with ``r = |y|``: Salomon 1996, doi:10.1016/0303-2647(96)01621-8."""
    n, d = y.shape
    for row in range(n):
        square = 0.0
        for i in range(d):
            square += y[row, i] ** 2
        r = math.sqrt(square)
        values[row] = 2.0 * math.sin(math.pi * r) ** 2 + 0.1 * r


def schaffer_f6(y: Floats, values: Floats) -> None:
    """``sum 1/2 + (sin(r)^2 - 1/2) / (1 + r^2/1000)^2``, ``r = |(y_i, y_{i+1})|``; the last has the first.

    Schaffer, Caruana, Eshelman and Das 1989, ICGA, F6; expanded by Suganthan et al. 2005, CEC 2005, F14.
    """
    n, d = y.shape
    for row in range(n):
        total = 0.0
        for i in range(d):
            square = y[row, i] ** 2 + y[row, (i + 1) % d] ** 2
            total += 0.5 + (math.sin(math.sqrt(square)) ** 2 - 0.5) / (1.0 + 0.001 * square) ** 2
        values[row] = total


def schaffer_f7(y: Floats, values: Floats) -> None:
    """``(mean of sqrt(r) (1 + sin(50 r^(1/5))^2))^2`` over neighbours, ``r = |(y_i, y_{i+1})|``.

    Schaffer, Caruana, Eshelman and Das 1989, ICGA, F7; in d dimensions Hansen et al. 2009, INRIA RR-6829, f17.
    """
    n, d = y.shape
    for row in range(n):
        total = 0.0
        for i in range(d - 1):
            r = math.sqrt(y[row, i] ** 2 + y[row, i + 1] ** 2)
            total += math.sqrt(r) * (1.0 + math.sin(50.0 * r**0.2) ** 2)
        values[row] = (total / (d - 1)) ** 2


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


def happy_cat(y: Floats, values: Floats) -> None:
    """``|r^2 - d|^(1/4) + (r^2/2 + sum z_i)/d + 1/2`` with ``r = |z|``, z* = -1.

    Beyer and Finck 2012, PPSN XII, doi:10.1007/978-3-642-32937-1_37, alpha = 1/8.
    """
    n, d = y.shape
    for row in range(n):
        square, beyond = 0.0, 0.0
        for i in range(d):
            square += y[row, i] ** 2
            beyond += y[row, i] * (y[row, i] - 2.0)  # z_i^2 - 1
        values[row] = math.sqrt(math.sqrt(abs(beyond))) + square / (2.0 * d)


def griewank_rosenbrock(y: Floats, values: Floats) -> None:
    """``sum t^2/4000 - cos(t) + 1`` of Rosenbrock's terms t of neighbours; the last has the first; z* = 1.

    Whitley, Rana, Dzubera and Mathias 1996, F8F2, doi:10.1016/0004-3702(95)00124-7.
    """
    n, d = y.shape
    for row in range(n):
        total = 0.0
        for i in range(d):
            bend = y[row, i] * (2.0 + y[row, i]) - y[row, (i + 1) % d]  # z_i^2 - z_{i+1}
            t = 100.0 * bend**2 + y[row, i] ** 2
            total += t**2 / 4000.0 + 2.0 * math.sin(t / 2.0) ** 2
        values[row] = total


def lunacek(y: Floats, values: Floats) -> None:
    """The smaller of two bowls, ``sum y_i^2`` and ``d + s sum (z_i - mu)^2``, plus Rastrigin's waves, z* = 2.5.

    ``s = 1 - 1/(2 sqrt(d + 20) - 8.2)``, ``mu = -sqrt((2.5^2 - 1)/s)``: Lunacek, Whitley and Sutton 2008, PPSN X,
    doi:10.1007/978-3-540-87700-4_50.
    """
    n, d = y.shape
    s = 1.0 - 1.0 / (2.0 * math.sqrt(d + 20.0) - 8.2)
    distance = 2.5 + math.sqrt((2.5**2 - 1.0) / s)
    for row in range(n):
        near, far, wave = 0.0, 0.0, 0.0
        for i in range(d):
            near += y[row, i] ** 2
            far += (y[row, i] + distance) ** 2
            wave += math.sin(math.pi * y[row, i]) ** 2
        values[row] = min(near, d + s * far) + 20.0 * wave
