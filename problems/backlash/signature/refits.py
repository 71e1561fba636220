"""Fit many signals that differ little from one whose reference fit is known, such as the resamples of a bootstrap.

The search is that of :mod:`~problems.backlash.signature.reference` without its scan: the window begins near that of the
known fit, tau and omega are found by climbing from its own, and the best length and weights are solved for.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.contract.typing import Floats
from problems.backlash.signature.kernel import Folded
from problems.backlash.signature.model import EDGE, OMEGA, T0, T1, TAU
from problems.backlash.signature.projection import Limits, Sums, profile
from problems.backlash.signature.reference import MARGIN, Window, prepare, settle

NEAR = 2  # the window begins at most this number of samples earlier or later
# The first steps of tau and omega, the factor of the next ones after the best of nine points, and their smallest scale.
STEPS, CLOSER, LEAST = (1.0, 2.0), 0.25, 5e-3


def fits_near(
    recording: Folded, signals: Iterable[Floats], lower: Floats, upper: Floats, near: Floats
) -> Iterator[Floats]:
    """Yield the (7,) point of the lowest RMSE near the (7,) point ``near`` for each signal (N,), within the bounds.

    A fit takes a quarter of a millisecond. The signals are the recording's, slightly changed.
    """
    limit, length, sums = prepare(recording, lower, upper, constrained=False)
    first = math.floor((near[T0] - recording.start + near[T1] + EDGE) / recording.dt) + 1
    starts = np.arange(max(first - NEAR, 1), min(first + NEAR, limit.last) + 1)
    tau, omega = float(near[TAU]), float(near[OMEGA])
    for signal in signals:
        sums_of = recording.sums._replace(s1=float(signal.sum()))  # the folded ones are not used
        changed = recording._replace(signal=signal, sums=sums_of)
        best = _best_window(tau, omega, starts, changed, sums, limit, length)
        yield np.clip(settle(Window(*best), changed, sums, limit, sweeps=None)[1], lower, upper)


@njit(cache=True, error_model="numpy")
def _best_window(
    tau: float, omega: float, starts: NDArray[np.int64], recording: Folded, sums: Sums, limit: Limits, length: int
) -> tuple[float, float, float, int, int, float, float]:
    """Return the fields of the best window of a recording near (tau, omega), among those from ``starts`` (m,).

    The sums are another signal's on the same grid; F is folded anew, as far as these windows reach. A start that
    explains less by more than the share ``MARGIN`` at the given point is left out.
    """
    f = np.zeros_like(sums.f)
    for i in range(starts[0], min(starts[-1] + length, sums.n)):
        for k in range(sums.replicas):
            at = i + k * sums.lag
            if at > sums.n - 1:
                break
            whole = math.floor(at)
            value = recording.signal[whole]
            if at > whole:
                value += (at - whole) * (recording.signal[whole + 1] - value)
            f[i] += value if k % 2 == 0 else -value
    changed = Sums(f, sums.g, sums.terms, sums.n, sums.dt, recording.sums.s1, sums.lag, sums.replicas)
    energies = np.empty(len(starts))
    for i in range(len(starts)):
        energies[i] = profile(tau, omega, starts[i], changed, limit, length)[0]
    least = (1 - MARGIN) * energies.max()
    best, start = (-1.0, tau, omega), int(starts[0])
    for i in range(len(starts)):
        if energies[i] >= least:
            climbed = _climb((energies[i], tau, omega), starts[i], changed, limit, length)
            if climbed[0] > best[0]:
                best, start = climbed, int(starts[i])
    energy, samples, sine, cosine = profile(best[1], best[2], start, changed, limit, length)
    return energy, best[1], best[2], start, samples, sine, cosine


@njit(cache=True, error_model="numpy")
def _climb(
    best: tuple[float, float, float], start: int, sums: Sums, limit: Limits, length: int
) -> tuple[float, float, float]:
    """Return energy, tau and omega of a local maximum near ``best``, another energy, tau and omega.

    A square of nine points moves to the best of them. Once that is its centre, the paraboloid through the nine gives
    one more point (Newton's step), and the square shrinks about the better one. A compass search, as the reference
    fit's, takes three times as many points to the same maximum.
    """
    low, high, scale, e = (limit.tau[0], limit.omega[0]), (limit.tau[1], limit.omega[1]), 1.0, np.empty((3, 3))
    while scale > LEAST:
        centre, e[1, 1] = best, best[0]
        for i in range(3):
            for j in range(3):
                if i == j == 1:
                    continue
                tau = min(max(centre[1] + (i - 1) * scale * STEPS[0], low[0]), high[0])
                omega = min(max(centre[2] + (j - 1) * scale * STEPS[1], low[1]), high[1])
                e[i, j] = profile(tau, omega, start, sums, limit, length)[0]
                if e[i, j] > best[0]:
                    best = e[i, j], tau, omega
        if best[0] > centre[0]:
            continue
        g_tau, g_omega = (e[2, 1] - e[0, 1]) / 2, (e[1, 2] - e[1, 0]) / 2
        h_tau, h_omega = e[2, 1] - 2 * e[1, 1] + e[0, 1], e[1, 2] - 2 * e[1, 1] + e[1, 0]
        h_both = (e[2, 2] - e[2, 0] - e[0, 2] + e[0, 0]) / 4
        det = h_tau * h_omega - h_both * h_both
        if det > 0.0:
            by_tau, by_omega = (h_both * g_omega - h_omega * g_tau) / det, (h_both * g_tau - h_tau * g_omega) / det
            tau = min(max(centre[1] + min(max(by_tau, -1.0), 1.0) * scale * STEPS[0], low[0]), high[0])
            omega = min(max(centre[2] + min(max(by_omega, -1.0), 1.0) * scale * STEPS[1], low[1]), high[1])
            energy = profile(tau, omega, start, sums, limit, length)[0]
            if energy > best[0]:
                best = energy, tau, omega
        scale *= CLOSER
    return best
