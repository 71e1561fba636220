"""The backlash signature: its variables, the literal formula, its box and its constraints (thesis chapters 3, 5, 7).

The literal formula is the definition; :mod:`problems.backlash.signature.kernel` computes the same numbers about ten
thousand times faster and is tested against this.
"""

import numpy as np

from bench.contract.typing import Floats

VARIABLES = ("A", "t0", "tau", "omega", "v_t", "T1", "T2")
A, T0, TAU, OMEGA, V_T, T1, T2 = range(7)

USUAL_TAU = 15.0  # 1/s; the signature's damping on the thesis's test bench
EDGE = 1e-9  # s; a sample this near to an end of a window counts as on it, hence outside: the window is open


def oscillation(u: Floats, x: Floats) -> Floats:
    """Return one damped oscillation at times ``u`` after its start t0 (eq. 3.5).

    T1 is the start offset and T2 the end offset, as in Table 7.1 and eq. 3.5 (section 7.2.2 prints the constraints
    with the two names exchanged). A is the amplitude at the start of the window.
    """
    decay = np.exp(-x[TAU] * np.maximum(u - x[T1], 0.0))  # capped: long before the window it would overflow
    inside = (u - x[T1] > EDGE) & (x[T2] - u > EDGE)
    return np.where(inside, x[A] * decay * np.sin(x[OMEGA] * u), 0.0)


def signature(t: Floats, x: Floats, *, period: float, replicas: int) -> Floats:
    """Return the signature h(t) plus the speed offset v_t, shaped like ``t`` (eqs. 3.5-3.7).

    The oscillations of f(t), (eq. 3.6), and of its n repetitions, (eq. 3.7), are one sequence: T_d = T_f / 2 apart, of
    alternating sign.

    Args:
        t: (N,) ascending times in s.
        x: (7,) the variables A, t0, tau, omega, v_t, T1, T2; A and v_t in the unit of the speed, the rest in s, 1/s
            and rad/s.
        period: T_f in s, the time of one load turn; T_d is half of it.
        replicas: the number of oscillations: 2 n for n load turns, 1 for a single one.
    """
    h = np.full_like(t, x[V_T])
    begins = x[T0] + period / 2 * np.arange(replicas)
    # with a margin for rounding; elsewhere an oscillation is 0
    firsts, ends = np.searchsorted(t, (begins + x[T1] - 2 * EDGE, begins + x[T2] + 2 * EDGE))
    for k, (first, end) in enumerate(zip(firsts, ends, strict=True)):
        h[first:end] += (-1.0) ** k * oscillation(t[first:end] - x[T0] - k * period / 2, x)
    return h


def rmse(speed: Floats, t: Floats, x: Floats, *, period: float, replicas: int) -> float:
    """Return the root-mean-square error between a speed signal and the signature (section 5.3.1), in its unit."""
    return float(np.sqrt(np.mean((speed - signature(t, x, period=period, replicas=replicas)) ** 2)))


def strength(x: Floats) -> float:
    """Return the strength of the oscillation of a (7,) point, in the unit of A: the root of its energy, scaled.

    The energy of a damped oscillation is A^2 / (4 tau). All samples determine its root, whereas A is the amplitude at
    one moment and trades with tau and T1. The scale makes it |A| at tau = 15 1/s, as on the bench.
    """
    return float(abs(x[A]) * np.sqrt(USUAL_TAU / x[TAU]))


def box(t: Floats, speed: Floats, *, period: float, amplitude_factor: float) -> tuple[Floats, Floats]:
    """Return the (7,) lower and upper bounds of Table 7.1 for a recording.

    Args:
        t: (N,) times in s.
        speed: (N,) speed about its mean.
        period: T_f in s. The table's limits of T1 and T2 (0.102 s and 0.204 s) grow with slower turns, so that T2
            can always reach T_d.
        amplitude_factor: A's bound in units of the signal's half range: 1.0 in Table 7.1; the authors' notebook, used
            for the comparison, has 1.3.
    """
    reach = amplitude_factor * (speed.max() - speed.min()) / 2
    last = max(0.204, period / 2)
    lower = np.array([-reach, t[0], 5.0, 2 * np.pi, speed.min(), 0.0, 0.0])
    upper = np.array([reach, t[-1], 30.0, 2 * np.pi * 40, speed.max(), last / 2, last])
    return lower, upper
