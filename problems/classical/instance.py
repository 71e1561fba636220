"""The optimum and the rotation of an instance."""

import zlib

import numpy as np
from numba import njit

from bench.contract.typing import Floats

MARGIN = 0.1  # the optimum keeps this share of the box from each side


def instance(function: str, dimension: int, number: int) -> tuple[Floats, Floats]:
    """Return the (d,) place of the optimum as shares of the box, and a (d, d) rotation, both random but repeatable."""
    rng = np.random.default_rng([zlib.crc32(function.encode()), dimension, number])
    shares = MARGIN + (1 - 2 * MARGIN) * rng.random(dimension)
    return shares, orthogonal(rng.standard_normal((dimension, dimension)))


@njit(cache=True)
def orthogonal(a: Floats) -> Floats:
    """Return the rows of the (d, d) matrix ``a`` made orthonormal in their order (Gram and Schmidt).

    Of independent normal numbers, it is a uniformly random rotation or reflection (Stewart 1980,
    doi:10.1137/0717034). Each row is projected twice, which makes it orthogonal to rounding; plain loops give the same
    bits with any linear algebra library.
    """
    d = len(a)
    rows = a.copy()
    for i in range(d):
        for _ in range(2):
            for j in range(i):
                product = 0.0
                for k in range(d):
                    product += rows[i, k] * rows[j, k]
                for k in range(d):
                    rows[i, k] -= product * rows[j, k]
        square = 0.0
        for k in range(d):
            square += rows[i, k] ** 2
        for k in range(d):
            rows[i, k] /= np.sqrt(square)
    return rows


@njit(cache=True)
def rotated(x: Floats, best: Floats, rotation: Floats) -> Floats:
    """Return the (n, d) offsets of the points ``x`` from ``best``, rotated: ``(x - best) @ rotation``.

    Each offset is summed in one order, which a matrix product of a library does not promise.
    """
    n, d = x.shape
    y = np.zeros((n, d))
    for row in range(n):
        for k in range(d):
            offset = x[row, k] - best[k]
            for i in range(d):
                y[row, i] += offset * rotation[k, i]
    return y
