"""Monotone cubic interpolation, by the formulas of ``scipy.interpolate.PchipInterpolator``, which is slow to import."""

from __future__ import annotations

import numpy as np

from bench.problem import Floats


class Pchip:
    """The piecewise cubic through points that grows where they grow (Fritsch and Butland 1984, doi:10.1137/0905021).

    Args:
        x: (m,) increasing, m >= 2.
        y: (m,) the values there.
    """

    def __init__(self, x: Floats, y: Floats) -> None:
        h = np.diff(x)
        slope = np.diff(y) / h
        d = _derivatives(h, slope)
        t = (d[:-1] + d[1:] - 2 * slope) / h
        self._x = x
        self._c = y[:-1], d[:-1], (slope - d[:-1]) / h - t, t / h  # by ascending powers

    def __call__(self, x: float) -> float:
        """Return the value at ``x``; NaN outside the points."""
        if not self._x[0] <= x <= self._x[-1]:
            return float("nan")
        i = min(int(np.searchsorted(self._x, x, side="right")), len(self._x) - 1) - 1
        s = x - self._x[i]
        c0, c1, c2, c3 = (float(c[i]) for c in self._c)
        return float(c0 + c1 * s + c2 * (s * s) + c3 * (s * s * s))


def _derivatives(h: Floats, slope: Floats) -> Floats:
    """Return the (m,) derivatives: harmonic means of the slopes beside a point, 0 at a turn, and three-point ends."""
    if len(slope) == 1:
        return np.repeat(slope, 2)
    flat = (np.sign(slope[1:]) != np.sign(slope[:-1])) | (slope[1:] == 0) | (slope[:-1] == 0)
    w1, w2 = 2 * h[1:] + h[:-1], h[1:] + 2 * h[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = (w1 / slope[:-1] + w2 / slope[1:]) / (w1 + w2)
        inside = np.where(flat, 0.0, 1 / mean)
    return np.concatenate([[_end(h[0], h[1], slope[0], slope[1])], inside, [_end(h[-1], h[-2], slope[-1], slope[-2])]])


def _end(h0: float, h1: float, slope0: float, slope1: float) -> float:
    """Return the one-sided three-point derivative at an end, limited so that the curve keeps its shape."""
    d = ((2 * h0 + h1) * slope0 - h0 * slope1) / (h0 + h1)
    if np.sign(d) != np.sign(slope0):
        return 0.0
    return 3 * slope0 if np.sign(slope0) != np.sign(slope1) and abs(d) > 3 * abs(slope0) else d
