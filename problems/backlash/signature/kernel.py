"""Compute the signature's RMSE, exact and fast, and the thesis's constraint repair.

Two identities give the literal formula's value without a pass over the whole signal:

1. ``exp(-tau t) sin(omega t)`` on a uniform grid is the imaginary part of a geometric sequence, so a sample costs a
   complex multiplication and no transcendental function.
2. When T_d is a whole number M of samples and the oscillations do not overlap, all 2n of them fall on the same
   sampling phase, so the sums over them are folded once per recording::

       F[i] = sum_k (-1)^k r[i + k M],  G[i] = sum_k (-1)^k,  C[i] = number of k,   over k with i + k M < N
       squared error = S2 - 2 c S1 + N c^2 + sum over the first window of y_i (C_i y_i - 2 (F_i - c G_i))

   with S1 = sum r and S2 = sum r^2: only the first window, at most T_d long, is passed over.

Anything else (overlapping oscillations, a T_d between samples, a fit so good that the folded difference would lose
digits) is summed directly. No fast-math: a value depends on the point alone, not on the processor's vector width.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from bench.contract.typing import Floats
from problems.backlash.signature.model import EDGE

LANES = 16  # samples per step of the recurrence: powers of the factor side by side vectorise, one chain does not


class SignalSums(NamedTuple):
    """The sums over a signal r that an evaluation needs.

    Attributes:
        twice_f: (N,) 2 F.
        twice_g: (N,) 2 G.
        terms: (N,) C.
        s1: sum of r.
        s2: sum of r^2.
    """

    twice_f: Floats
    twice_g: Floats
    terms: Floats
    s1: float
    s2: float


class Folded(NamedTuple):
    """A recording prepared for evaluation.

    Attributes:
        signal: (N,) the speed r about its mean.
        sums: over the signal.
        start: time of the first sample, s.
        dt: sampling period, s.
        delay: T_d in s.
        replicas: 2 n, the number of oscillations.
        shift: M, T_d in samples, or 0 where it is no whole number.
    """

    signal: Floats
    sums: SignalSums
    start: float
    dt: float
    delay: float
    replicas: int
    shift: int


def fold(signal: Floats, *, start: float, dt: float, period: float, replicas: int) -> Folded:
    """Return the folded sums of a recording whose (N,) samples start at ``start`` s and lie ``dt`` s apart."""
    n = len(signal)
    exact = period / 2 / dt
    shift = round(exact) if abs(exact - round(exact)) * dt * replicas < EDGE else 0
    if replicas == 1:  # nothing to overlap with
        shift = n
    f, g, terms = np.zeros(n), np.zeros(n), np.zeros(n)
    for k in range(replicas if shift else 0):
        if (length := n - k * shift) <= 0:
            break
        f[:length] += (-1.0) ** k * signal[k * shift :]
        g[:length] += (-1.0) ** k
        terms[:length] += 1.0
    start, dt = float(start), float(dt)  # a whole number would make numba compile every kernel again
    sums = SignalSums(2 * f, 2 * g, terms, float(signal.sum()), float((signal**2).sum()))
    return Folded(signal, sums, start, dt, period / 2, replicas, shift)


@njit(cache=True, error_model="numpy")
def evaluate(points: Floats, recording: Folded) -> Floats:
    """Return the (n,) RMSEs of (n, 7) points in the order of ``VARIABLES``; +inf for a point that is not finite."""
    n = len(recording.signal)
    values = np.empty(len(points))
    model = np.empty(n)
    re, im, lanes = np.empty(LANES), np.empty(LANES), np.empty(LANES)
    sums, start, dt, shift = recording.sums, recording.start, recording.dt, recording.shift
    for p in range(len(points)):
        a, t0, tau, omega = points[p, 0], points[p, 1], points[p, 2], points[p, 3]
        c, t1, t2 = points[p, 4], points[p, 5], points[p, 6]
        if not abs(a + t0 + tau + omega + c + t1 + t2) < np.inf:
            values[p] = np.inf
            continue
        # The open window (t0 + T1, t0 + T2) in samples; clamped as floats, since far ones do not fit an integer.
        begin, end = (t0 - start + t1 + EDGE) / dt, (t0 - start + t2 - EDGE) / dt
        first = math.floor(min(max(begin, -1.0), n)) + 1
        last = math.ceil(min(max(end, 0.0), n))
        squares = sums.s2 - 2 * c * sums.s1 + n * c * c
        folded = shift > 0 and begin >= -1.0 and (last - first <= shift if end <= n else end - begin < shift - 1.0)
        if folded and last > first:
            u = start + first * dt - t0
            amplitude, phase = a * _exp_of_minus(tau * (u - t1)), omega * u
            z_re, z_im = amplitude * math.cos(phase), amplitude * math.sin(phase)
            q, (cosine, sine) = _exp_of_minus(tau * dt), _cos_sin(omega * dt)
            squares += _first_window(z_re, z_im, q * cosine, q * sine, c, first, last, sums, re, im, lanes)
        if not folded or squares < 1e-6 * sums.s2:
            squares = _direct(a, t0, tau, omega, c, t1, t2, recording, model)
        values[p] = math.sqrt(max(squares, 0.0) / n) if squares < np.inf else np.inf  # overflow, far outside the box
    return values


@njit(cache=True, error_model="numpy", inline="always")
def _first_window(
    z_re: float, z_im: float, q_re: float, q_im: float, c: float, first: int, last: int, sums: SignalSums,
    re: Floats, im: Floats, lanes: Floats,
) -> float:  # fmt: skip
    """Return the sum of y (C y - 2 F + 2 c G) over samples first … last - 1, where y_j = Im(z q^j)."""
    re[0], im[0] = 1.0, 0.0  # q^0 … q^15 by doubling: short chains of multiplications, not one long one
    for half in (1, 2, 4, 8):
        for j in range(half):
            re[half + j] = re[j] * q_re - im[j] * q_im
            im[half + j] = re[j] * q_im + im[j] * q_re
        q_re, q_im = q_re * q_re - q_im * q_im, 2 * q_re * q_im  # q^2, q^4, q^8 and, to step by, q^16
    lanes[:] = 0.0
    terms, twice_f, twice_g = sums.terms, sums.twice_f, sums.twice_g
    # Unsigned, so that the compiler need not expect an index counted from the end, and vectorises.
    base, end = np.uintp(first), np.uintp(last)
    width = np.uintp(LANES)
    while base + width <= end:
        for j in range(width):
            y = z_re * im[j] + z_im * re[j]
            lanes[j] += y * (terms[base + j] * y - (twice_f[base + j] - c * twice_g[base + j]))
        z_re, z_im = z_re * q_re - z_im * q_im, z_re * q_im + z_im * q_re
        base += width
    for j in range(end - base):
        y = z_re * im[j] + z_im * re[j]
        lanes[j] += y * (terms[base + j] * y - (twice_f[base + j] - c * twice_g[base + j]))
    for half in (8, 4, 2, 1):  # the lanes' sum in a fixed order
        for j in range(half):
            lanes[j] += lanes[half + j]
    total: float = lanes[0]
    return total


@njit(inline="always")
def _exp_of_minus(x: float) -> float:
    """Return exp(-x): for the small x of one sampling step its Taylor polynomial, exact to rounding."""
    if not 0.0 <= x <= 0.125:
        return math.exp(-x)
    y, y2 = -x, x * x
    low = (1 + y) + y2 * (1 / 2 + y / 6)
    high = (1 / 24 + y * (1 / 120)) + y2 * (1 / 720 + y * (1 / 5040))
    return low + y2 * y2 * (high + y2 * y2 * (1 / 40320 + y * (1 / 362880)))


@njit(inline="always")
def _cos_sin(x: float) -> tuple[float, float]:
    """Return cos x and sin x: for the small turn of one sampling step their Taylor polynomials, exact to rounding."""
    if abs(x) > 0.6:
        return math.cos(x), math.sin(x)
    y = x * x
    y2 = y * y
    cosine = ((1 - y * (1 / 2)) + y2 * (1 / 24 - y * (1 / 720))) + y2 * y2 * (
        (1 / 40320 - y * (1 / 3628800)) + y2 * (1 / 479001600 - y * (1 / 87178291200))
    )
    sine = ((1 - y * (1 / 6)) + y2 * (1 / 120 - y * (1 / 5040))) + y2 * y2 * (
        (1 / 362880 - y * (1 / 39916800)) + y2 * (1 / 6227020800 - y * (1 / 1307674368000))
    )
    return cosine, x * sine


@njit(cache=True, error_model="numpy")
def _direct(
    a: float, t0: float, tau: float, omega: float, c: float, t1: float, t2: float, recording: Folded, model: Floats
) -> float:
    """Return the squared error summed over all N samples, each oscillation placed at its own sampling phase."""
    n, dt = len(recording.signal), recording.dt
    model[:] = c
    q = math.exp(-tau * dt)
    q_re, q_im = q * math.cos(omega * dt), q * math.sin(omega * dt)
    for k in range(recording.replicas):
        origin = t0 + k * recording.delay - recording.start
        first = math.floor(min(max((origin + t1 + EDGE) / dt, -1.0), n)) + 1
        last = math.ceil(min(max((origin + t2 - EDGE) / dt, 0.0), n))
        if first >= last:
            continue
        u = first * dt - origin
        amplitude = (a if k % 2 == 0 else -a) * math.exp(-tau * (u - t1))
        z_re, z_im = amplitude * math.cos(omega * u), amplitude * math.sin(omega * u)
        for i in range(first, last):
            model[i] += z_im
            z_re, z_im = z_re * q_re - z_im * q_im, z_re * q_im + z_im * q_re
    squares = 0.0
    for i in range(n):
        squares += (recording.signal[i] - model[i]) ** 2
    return squares


@njit(cache=True)
def repair(points: Floats, lower: Floats, upper: Floats, start: float, stop: float, delay: float) -> Floats:
    """Return (n, 7) points with every value capped at the limit it breaks, first of the box, then of section 7.2.2.

    In eq. 3.5's names: 0 < T1 < pi / (2 omega) (the oscillation starts within its first quarter period),
    T1 < T2 < T_d, and t0 between ``start`` and ``stop`` - T2, the recording's ends.
    """
    fixed = np.empty_like(points)
    for p in range(len(points)):
        for j in range(7):
            fixed[p, j] = min(max(points[p, j], lower[j]), upper[j])
        fixed[p, 5] = min(fixed[p, 5], math.pi / (2 * fixed[p, 3]), delay)
        fixed[p, 6] = min(max(fixed[p, 6], fixed[p, 5]), delay)
        fixed[p, 1] = min(max(fixed[p, 1], start), stop - fixed[p, 6])
    return fixed
