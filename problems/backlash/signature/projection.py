"""Solve for the signature's linear variables exactly, for a given window, tau and omega (variable projection).

Relative to the first sample in its window, an oscillation is a damped sine and cosine, and the fit is linear in their
weights and the offset v_t: for a window and a pair (tau, omega) the best weights solve two linear equations (variable
projection, Golub and Pereyra 1973, doi:10.1137/0710036). T1, t0 and the bounds limit the phase at that sample to a
range 0 … omega u, so the weights lie in a double cone, and the best weights are inside it, on its edge, or as large as
the bound of A allows. The energy that a fit explains is N times its reduction of the signal's mean square.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from bench.contract.typing import Floats
from problems.backlash.signature.kernel import Folded
from problems.backlash.signature.model import EDGE, OMEGA, T1, T2, TAU, A

SINGULAR = 1e-12  # a determinant this small, relative to its terms, cannot distinguish sine and cosine
NEWTON = 50  # the largest number of Newton steps to the length that A's bound allows; five are usual
CLEARANCE = 1.01 * EDGE  # s; the distance of a window's end from a sample that the window must include


class Limits(NamedTuple):
    """The bounds of a fit: the box and, if requested, the constraints of section 7.2.2.

    Attributes:
        tau, omega: lower and upper bound, 1/s and rad/s.
        reach: upper bound of abs(A).
        t1: upper bound of T1, s.
        t2: upper bound of T2, s.
        quarter: whether T1 is at most a quarter period.
        last: index of the last sample that may lie in the first window.
    """

    tau: tuple[float, float]
    omega: tuple[float, float]
    reach: float
    t1: float
    t2: float
    quarter: bool
    last: int


def limits(recording: Folded, lower: Floats, upper: Floats, *, constrained: bool) -> Limits:
    """Return the limits from the (7,) bounds and, with ``constrained``, from the constraints."""
    t1, t2, last = float(upper[T1]), float(upper[T2]), len(recording.signal) - 1
    if constrained:  # T1 < T2 < T_d, and t0 + T2 within the recording, so that its last sample is outside
        t1, t2, last = min(t1, recording.delay), min(t2, recording.delay), last - 1
    tau, omega = (float(lower[TAU]), float(upper[TAU])), (float(lower[OMEGA]), float(upper[OMEGA]))
    return Limits(tau, omega, float(upper[A]), t1, t2, constrained, last)


class Sums(NamedTuple):
    """The folded sums that a scan needs, padded with zeros beyond the end.

    Attributes:
        f, g, terms: F, G and C of :mod:`problems.backlash.signature.kernel`.
        n: N, the samples of the signal.
        dt: sampling period, s.
        s1: sum of the signal.
        lag: T_d in samples.
        replicas: the number of oscillations.
    """

    f: Floats
    g: Floats
    terms: Floats
    n: int
    dt: float
    s1: float
    lag: float
    replicas: int


def fold_sums(recording: Folded, length: int) -> Sums:
    """Return the folded sums, of the interpolated signal if T_d lies between samples."""
    n, dt = len(recording.signal), recording.dt
    f, g, terms = recording.sums.twice_f / 2, recording.sums.twice_g / 2, recording.sums.terms
    if not recording.shift:
        f, g, terms, index = np.zeros(n), np.zeros(n), np.zeros(n), np.arange(n)
        for k in range(recording.replicas):
            at = index + k * recording.delay / dt
            sign, inside = (-1.0) ** k, at <= n - 1
            f += sign * np.where(inside, np.interp(at, index, recording.signal), 0.0)
            g += sign * inside
            terms += inside
    beyond = (0, 3 * length)
    lag = float(recording.shift) or recording.delay / dt
    f, g, terms = (np.pad(sums, beyond) for sums in (f, g, terms))
    return Sums(f, g, terms, n, dt, recording.sums.s1, lag, recording.replicas)


@njit(cache=True, error_model="numpy")
def overlap(
    tau: float, omega: float, im: float, re: float, j: int, turns: int, sums: Sums
) -> tuple[float, float, float]:
    """Return the addition to ss, sc and cc by a pair of a window's sample j and one ``turns`` half turns later.

    ``im`` and ``re`` are the damped sine and cosine at sample j.
    """
    u = (j - turns * sums.lag) * sums.dt
    size = math.exp(-tau * u) if turns % 2 == 0 else -math.exp(-tau * u)
    sine, cosine = size * math.sin(omega * u), size * math.cos(omega * u)
    return 2 * im * sine, im * cosine + re * sine, 2 * re * cosine


@njit(cache=True, error_model="numpy")
def largest_t1(omega: float, limit: Limits) -> float:
    """Return the largest T1 in s: under the constraints an oscillation starts within its first quarter period."""
    largest: float = min(limit.t1, math.pi / (2 * omega)) if limit.quarter else limit.t1
    return largest


@njit(cache=True, error_model="numpy")
def largest_phase(omega: float, start: int, extent: int, sums: Sums, limit: Limits) -> float:
    """Return the largest phase that an oscillation may have at its first sample; not positive if no phase is allowed.

    Its time since t0 is limited by t0 >= the recording's start, by T1, which may be a sample before, and by T2, which
    must be later than the last sample, ``extent`` samples on.
    """
    dt = sums.dt
    latest: float = min(start * dt, largest_t1(omega, limit) + dt, limit.t2 - extent * dt - CLEARANCE)
    return omega * latest


@njit(cache=True, error_model="numpy")
def weights(
    ss: float, sc: float, cc: float, s: float, c: float, phase: float, reach: float, least: float
) -> tuple[float, float, float]:
    """Return the energy that sine and cosine explain and their weights z, the best in the double cone.

    The energy is 2 (s, c) z - z' [[ss, sc], [sc, cc]] z; the angle of z is 0 … ``phase`` (or opposite), its length at
    most ``reach``. Zeros are returned if even the best of all z would explain no more than ``least``.
    """
    top = min(phase, math.pi)
    det = ss * cc - sc * sc
    if not det > SINGULAR * ss * cc:  # a window of one sample determines no phase
        best: tuple[float, float, float] = _ray(ss, sc, cc, s, c, min(top, math.pi / 2), reach)
        return best
    a, b = (cc * s - sc * c) / det, (ss * c - sc * s) / det
    if s * a + c * b <= least:
        return 0.0, 0.0, 0.0
    angle, size = math.atan2(b, a), math.hypot(a, b)
    if (angle if angle >= 0.0 else angle + math.pi) <= top and size <= reach:
        return s * a + c * b, a, b
    lower, upper = _ray(ss, sc, cc, s, c, 0.0, reach), _ray(ss, sc, cc, s, c, top, reach)
    best = lower if lower[0] > upper[0] else upper
    if size > reach:  # the best as long as allowed: (M + lambda I) z = f, by Newton's method on 1/|z| (Moré 1983)
        shift = 0.0
        for _ in range(NEWTON):
            det = (ss + shift) * (cc + shift) - sc * sc
            a, b = ((cc + shift) * s - sc * c) / det, ((ss + shift) * c - sc * s) / det
            size = math.hypot(a, b)
            if abs(size - reach) <= SINGULAR * reach:
                break
            slope = (a * ((cc + shift) * a - sc * b) + b * ((ss + shift) * b - sc * a)) / det
            shift += size * size / slope * (size - reach) / reach
        angle = math.atan2(b, a)
        if (angle if angle >= 0.0 else angle + math.pi) <= top:  # else the best is on an edge, by convexity
            a, b = a * reach / size, b * reach / size
            best = 2 * (s * a + c * b) - (ss * a * a + 2 * sc * a * b + cc * b * b), a, b
    return best


@njit(cache=True, error_model="numpy")
def _ray(ss: float, sc: float, cc: float, s: float, c: float, angle: float, reach: float) -> tuple[float, float, float]:
    """Return the energy and the weights of the best fit of one phase."""
    x, y = math.cos(angle), math.sin(angle)
    square = ss * x * x + 2 * sc * x * y + cc * y * y
    if not square > 0.0:
        return 0.0, 0.0, 0.0
    size = min(max((s * x + c * y) / square, -reach), reach)
    return size * (2 * (s * x + c * y) - size * square), size * x, size * y


@njit(cache=True, error_model="numpy")
def solve_cell(total: Floats, sums: Sums, phase: float, reach: float, least: float) -> tuple[float, float, float]:
    """Return energy and weights of one window from its seven sums, the offset v_t eliminated; see `weights`."""
    gs, gc = total[3] / sums.n, total[4] / sums.n
    best: tuple[float, float, float] = weights(
        total[0] - total[3] * gs, total[1] - total[3] * gc, total[2] - total[4] * gc,
        total[5] - gs * sums.s1, total[6] - gc * sums.s1, phase, reach, least,
    )  # fmt: skip
    return best


@njit(cache=True, error_model="numpy")
def profile(
    tau: float, omega: float, start: int, sums: Sums, limit: Limits, length: int
) -> tuple[float, int, float, float]:
    """Return the most energy that a window from ``start`` explains, its number of samples, and the weights."""
    q = math.exp(-tau * sums.dt)
    re, im, q_re, q_im = 1.0, 0.0, q * math.cos(omega * sums.dt), q * math.sin(omega * sums.dt)
    total = np.zeros(7)
    best, samples, sine, cosine = 0.0, 0, 0.0, 0.0
    for j in range(min(length, limit.last + 1 - start)):
        terms, g, f = sums.terms[start + j], sums.g[start + j], sums.f[start + j]
        for turns in range(1, math.floor(j / sums.lag) + 1):
            pairs = min(terms, float(sums.replicas - turns))
            ss, sc, cc = overlap(tau, omega, im, re, j, turns, sums)
            total[0] += pairs * ss
            total[1] += pairs * sc
            total[2] += pairs * cc
        total[0] += terms * (im * im)
        total[1] += terms * (im * re)
        total[2] += terms * (re * re)
        total[3] += g * im
        total[4] += g * re
        total[5] += f * im
        total[6] += f * re
        phase = largest_phase(omega, start, j, sums, limit)
        if phase > 0.0:
            energy, a, b = solve_cell(total, sums, phase, limit.reach, best)
            if energy > best:
                best, samples, sine, cosine = energy, j + 1, a, b
        re, im = re * q_re - im * q_im, re * q_im + im * q_re
    return best, samples, sine, cosine


@njit(cache=True, error_model="numpy")
def explained(at: Floats, recording: Folded, limit: Limits) -> tuple[float, float, float, float]:
    """Return the energy explained, the weights of sine and cosine at the window's begin, and the offset v_t.

    The point is tau, omega, begin and end of the first window in s; every oscillation is summed sample by sample.
    """
    tau, omega, begin, end = at[0], at[1], at[2], at[3]
    n, dt, start = len(recording.signal), recording.dt, recording.start
    # The longest time from t0 to the begin.
    since = min(begin - start, largest_t1(omega, limit), limit.t2 - (end - begin))
    if since < 0.0 or end <= begin or end > start + (limit.last + 1) * dt:
        return -1.0, 0.0, 0.0, 0.0
    sine, cosine = np.zeros(n), np.zeros(n)
    q = math.exp(-tau * dt)
    q_re, q_im = q * math.cos(omega * dt), q * math.sin(omega * dt)
    for k in range(recording.replicas):
        begins = begin - start + k * recording.delay
        first = max(math.floor((begins + EDGE) / dt) + 1, 0)
        beyond = min(math.ceil((begins + end - begin - EDGE) / dt), n)
        since_begin = first * dt - begins
        size = (1.0 if k % 2 == 0 else -1.0) * math.exp(-tau * since_begin)
        re, im = size * math.cos(omega * since_begin), size * math.sin(omega * since_begin)
        for i in range(first, beyond):
            sine[i] += im
            cosine[i] += re
            re, im = re * q_re - im * q_im, re * q_im + im * q_re
    ss = sc = cc = gs = gc = s = c = 0.0
    for i in range(n):
        ss += sine[i] * sine[i]
        sc += sine[i] * cosine[i]
        cc += cosine[i] * cosine[i]
        gs += sine[i]
        gc += cosine[i]
        s += sine[i] * recording.signal[i]
        c += cosine[i] * recording.signal[i]
    mean, gs, gc = recording.sums.s1 / n, gs / n, gc / n
    energy, a, b = weights(
        ss - n * gs * gs, sc - n * gs * gc, cc - n * gc * gc, s - n * gs * mean, c - n * gc * mean,
        omega * since, limit.reach, 0.0,
    )  # fmt: skip
    return energy, a, b, mean - a * gs - b * gc
