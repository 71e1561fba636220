"""Test and interval of the mean of independent values between 0 and 1, with no assumption on their distribution.

Of n values from one distribution on [0, 1], Gaffke (2005, Mathematical Methods of Statistics 14) bounds the mean from
below by quantiles of their random weighted mean: the weights of the values, and of a further 0, are uniform on the
simplex. For values 0 and 1 this is the interval of Clopper and Pearson (1934, Biometrika 26). For more values its level
is a conjecture, to which no counterexample is known (Learned-Miller and Thomas 2019, arXiv:1905.06208); simulations of
skewed values are in validation/claims.py. Student's t and Wilcoxon's signed ranks err far more often than they state
where values are skewed, and no test of a mean is valid for values without bounds (Bahadur and Savage 1956, The Annals
of Mathematical Statistics 27).

The density of such a weighted mean is the B-spline that has the values as its knots (Curry and Schoenberg 1966, Journal
d'Analyse Mathématique 17), so its distribution function has the recurrence of B-splines: exact, and of convex
combinations only.
"""

from __future__ import annotations

import numpy as np

from bench.typing import Flags, Floats

HALVINGS = 34  # of the range of an end of an interval: ten digits


def p_values(values: Floats, mean: float = 0.5) -> Floats:
    """Return the two-sided p-values of a mean, (g,), from (n, g) values; 1 where there is no value."""
    at = np.full(values.shape[1], mean)
    sides = np.minimum(p_of_at_most(values, at), p_of_at_most(1 - values, 1 - at))
    return np.asarray(np.minimum(2 * sides, 1.0))


def p_of_at_most(values: Floats, means: Floats) -> Floats:
    """Return the p-values of the hypotheses that the means are at most ``means``, (g,), from (n, g) values."""
    knots = np.sort(np.append(np.zeros((1, values.shape[1])), values, axis=0), axis=0)
    below = (knots <= means).astype(np.float64)  # the distribution function of one knot; those of more follow
    for more in range(1, len(knots)):
        low, high = knots[:-more], knots[more:]
        width = high - low
        share = np.divide(means - low, width, out=(low <= means).astype(np.float64), where=width > 0).clip(0.0, 1.0)
        below = share * below[:-1] + (1 - share) * below[1:]
    return np.asarray(below[0])


def intervals(values: Floats, level: float = 0.95) -> tuple[Floats, Floats]:
    """Return both ends of the intervals of the means, (g,) each, from (n, g) values; 0 and 1 where there is none."""
    return _lowest(values, (1 - level) / 2), 1 - _lowest(1 - values, (1 - level) / 2)


def _lowest(values: Floats, alpha: float) -> Floats:
    """Return the smallest means, (g,), that the one-sided tests at ``alpha`` do not reject."""
    low, high = np.zeros(values.shape[1]), np.ones(values.shape[1])
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        rejected: Flags = p_of_at_most(values, middle) <= alpha
        low, high = np.where(rejected, middle, low), np.where(rejected, high, middle)
    return low
