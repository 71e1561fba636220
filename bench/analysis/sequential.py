"""Spend a level of significance over declared looks at growing data, and adjust p-values for all of these looks.

Every look at the data is one more chance to reject a true hypothesis. The spending function of Lan and DeMets (1983,
Biometrika 70) of the kind of O'Brien and Fleming (1979, Biometrics 35) fixes how much of the level alpha may be used
up by the time that a share t of all trials has been made:

    spent(t) = 4 - 4 Phi(z / sqrt(t)),  z = Phi^-1(1 - alpha / 4)

which is next to nothing early on, and alpha at the end: each of the two sides spends alpha / 2. The boundary c_k of
the statistic |Z_k| at look k is such that the chance to cross any boundary up to look k is spent(t_k). Z_k sqrt(t_k) is
a Brownian motion at the times t_k under the hypothesis, as it is for sums of independent values, and asymptotically for
statistics of ranks; the chance is computed by the recursion of Armitage, McPherson and Rowe (1969, Journal of the Royal
Statistical Society A 132).

The p-value of a look, from whatever test, is compared with the nominal level 2 - 2 Phi(c_k). The repeated p-value
(Jennison and Turnbull 1999, Group Sequential Methods, chapter 9) is the smallest alpha with which the look would
reject. It is valid at every look, whatever the data said before, so any adjustment for several hypotheses takes it as
it takes a p-value of a single look; with Holm's method that is the group sequential Holm procedure (Ye, Li, Liu and
Yao 2013, Statistics in Medicine 32).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri

from bench.typing import Floats

LEAST, MOST = 1e-12, 0.5  # levels between which repeated p-values are known; larger ones count as 1
KNOTS = 50  # levels computed between them; the others are interpolated
FURTHEST = 37.0  # standard deviations; the tail beyond is 0 in float64
NODES = 6.5  # of the quadrature: half the width of the range in standard deviations of the next step, times this
SIZES = (64, 128, 256, 512, 1024)  # numbers of nodes


def spent(alpha: float, share: float) -> float:
    """Return how much of ``alpha`` may be used up once a ``share``, 0 to 1, of all trials has been made."""
    return float(4 * ndtr(ndtri(alpha / 4) / np.sqrt(share)))


def boundaries(shares: Sequence[float], alpha: float) -> list[float]:
    """Return the two-sided boundary of |Z| at each look; infinite where the level to spend is too small for a float.

    Args:
        shares: the share of all trials at each look, increasing, 1 at the last.
        alpha: the level over all looks.
    """
    limits: list[float] = []
    nodes, density, used = np.zeros(1), np.ones(1), 0.0  # of the sums that crossed no boundary so far
    steps = np.sqrt(np.diff([0.0, *shares, 2.0 * shares[-1]]))  # the standard deviations of the steps to the looks
    for share, step, next_step in zip(shares, steps, steps[1:], strict=False):
        wanted = spent(alpha, share) - used
        arguments = nodes / step, density, np.sqrt(share) / step, wanted
        beyond = _excess(FURTHEST, *arguments) >= 0
        limit = float("inf") if beyond else float(brentq(_excess, 0.0, FURTHEST, args=arguments, xtol=1e-10))
        limits.append(limit)
        used += wanted if np.isfinite(limit) else 0.0
        # The density beyond 9 standard deviations does not matter, and nodes there would be missed inside.
        reach = min(limit, 9.0) * np.sqrt(share)
        least = NODES * reach / min(step, next_step)
        places, weights = _gauss(next((size for size in SIZES if size >= least), SIZES[-1]))
        places, weights = places * reach, weights * reach
        moved = np.exp(-0.5 * ((places[:, np.newaxis] - nodes) / step) ** 2) / (step * np.sqrt(2 * np.pi))
        nodes, density = places, weights * (moved @ density)
    return limits


def _excess(limit: float, places: Floats, density: Floats, unit: float, wanted: float) -> float:
    """Return by how much the chance to cross a limit at the next look exceeds the wanted one.

    ``places`` of the sum so far, and ``unit``, that of Z at the look, are in standard deviations of the step to it.
    """
    return float(density @ (ndtr(places - limit * unit) + ndtr(-places - limit * unit))) - wanted


@lru_cache
def _gauss(number: int) -> tuple[Floats, Floats]:
    """Return places and weights of a quadrature on (-1, 1)."""
    places, weights = np.polynomial.legendre.leggauss(number)
    return places, weights


@lru_cache
def levels(looks: tuple[int, ...], alpha: float) -> tuple[float, ...]:
    """Return the nominal level of each look: a p-value at most as large is significant there at ``alpha`` over all.

    ``looks`` are the numbers of trials at which the data are looked at, increasing.
    """
    return tuple(float(2 * ndtr(-limit)) for limit in boundaries([look / looks[-1] for look in looks], alpha))


def repeated_p(p: ArrayLike, looks: Sequence[int], place: int) -> Floats:
    """Return the repeated p-values of the p-values of the look at this ``place``, which are never smaller.

    Those above a half are given as 1.
    """
    raw = np.asarray(p, dtype=np.float64)
    nominal, overall = _curve(tuple(looks), place)
    repeated = np.ones(raw.shape)
    if len(nominal) < 2:  # so early that next to nothing is spent
        return repeated
    above_least = raw > nominal[0]
    inverse = PchipInterpolator(np.log(nominal), np.log(overall))
    inside = above_least & (raw <= nominal[-1])
    repeated[inside] = np.exp(inverse(np.log(raw[inside])))
    repeated[~above_least] = overall[0]
    return np.asarray(np.maximum(repeated, raw))


@lru_cache
def _curve(looks: tuple[int, ...], place: int) -> tuple[Floats, Floats]:
    """Return increasing nominal levels of the look at this place, and the levels over all looks that they belong to."""
    overall = np.geomspace(LEAST, MOST, KNOTS)
    nominal = np.array([levels(looks, float(alpha))[place] for alpha in overall])
    usable = nominal > np.maximum.accumulate(np.append(1e-300, nominal[:-1]))
    return nominal[usable], overall[usable]
