"""Test whether a fit is more than noise, and resample it to find how well its amplitude is known.

The reference fit is the best of millions. So the p-value of an F test on its share of the signal's energy, for the
three weights that are solved for, is multiplied by the number of fits compared (Bonferroni). Noise is seldom white; its
first autocorrelation reduces the number of samples that count (Bartlett 1946).
"""

import math

import numpy as np
from scipy.special import fdtrc, fdtri  # scipy.stats.f takes them too, and 0.5 s longer to import

from bench.contract.typing import Floats
from problems.backlash.signature.model import T0, T1
from problems.backlash.signature.problem import SignatureFit
from problems.backlash.signature.reference import OMEGAS, TAUS

SOLVED = 3  # weights of sine, cosine and offset
OTHERS = 3  # further oscillations that are subtracted at most before the rest is taken for noise
FEWEST = 4  # half turns to draw residuals from
SIGNIFICANT = 1e-3  # the largest adjusted p-value at which a disturbance is detected

BENCH = (0.0, 15.6, 133.5, np.pi / 2 / 133.5)
"""t0, tau, omega and T1 of the thesis's test bench, from the poles of its closed transmission: a usual signature."""


def p_value(problem: SignatureFit, fitted: Floats) -> float:
    """Return the adjusted p-value of a fit (N,) to the problem's signal, from 0 to 1."""
    residual = problem.signal - fitted
    energy = float(problem.signal @ problem.signal - residual @ residual)
    p = _p_value(problem, energy, residual)
    for _ in range(OTHERS if problem.replicas == 1 else 0):
        if p <= SIGNIFICANT:
            break
        remaining = problem.beside(residual)
        residual = residual - remaining.model(remaining.reference().x)
        p = _p_value(problem, energy, residual)
    return p


def _p_value(problem: SignatureFit, energy: float, residual: Floats) -> float:
    """Return the adjusted p-value of an explained energy, where the residual (N,) is noise."""
    noise, counted = float(residual @ residual), effective(residual) - SOLVED - len(problem.variables)
    if counted < 1 or energy <= 0.0:
        return 1.0
    statistic = energy / SOLVED / (max(noise, 1e-12 * energy) / counted)
    return float(min(1.0, fdtrc(SOLVED, counted, statistic) * _looked_at(problem)))


def detectable(problem: SignatureFit) -> float:
    """Return the smallest detectable amplitude of a usual signature, in the problem's unit, were all signal noise."""
    t0, tau, omega, t1 = BENCH
    wave = problem.model(np.array([1.0, problem.time[0] + t0, tau, omega, 0.0, t1, problem.period / 2]))
    counted = effective(problem.signal) - SOLVED - len(problem.variables)
    if counted < 1:
        return np.inf
    threshold = SOLVED * fdtri(SOLVED, counted, 1 - SIGNIFICANT / _looked_at(problem)) / counted
    noise = float(problem.signal @ problem.signal)
    return float(np.sqrt(threshold * noise / (wave @ wave)))


def effective(residual: Floats) -> float:
    """Return the number of independent samples that determine their mean as well as these (N,) do."""
    centred = residual - residual.mean()
    total = float(centred @ centred)
    if total == 0.0:
        return float(len(residual))
    correlation = max(float(centred[1:] @ centred[:-1]) / total, 0.0)
    return len(residual) * (1 - correlation) / (1 + correlation)


def resampled(problem: SignatureFit, x: Floats, resamples: int, rng: np.random.Generator) -> Floats:
    """Return (resamples, 7) fits to the fit plus its residuals, resampled by half load turns (residual bootstrap).

    Whole half turns are drawn, so that the noise keeps its colour; each gets the sign of its place, so that the part of
    every oscillation which the signature misses remains (Efron and Tibshirani 1993, section 9.5; Künsch 1989).
    A single oscillation has no half turns; its blocks are a tenth of the signal.
    """
    fitted = problem.model(x)
    residual = problem.signal - fitted
    n = len(residual)
    block = max(round(problem.period / 2 / problem.dt) if problem.replicas > 1 else n // 10, 1)
    whole, places = max(n // block, 1), -(-n // block)
    signs = ((-1.0) ** np.arange(places) if problem.replicas > 1 else np.ones(places))[:, np.newaxis]
    signed = residual[: whole * block].reshape(whole, -1) * signs[:whole]
    # There may be half an oscillation before the first window, which is not fitted.
    begun = (x[T0] + x[T1] - problem.time[0]) / (block * problem.dt)
    if problem.replicas > 1 and (after := math.ceil(begun)) <= whole - FEWEST:
        signed = signed[after:]
    draws = (signed[rng.integers(len(signed), size=places)] * signs for _ in range(resamples))
    return problem.near(x, (fitted + drawn.ravel()[:n] for drawn in draws))


def _looked_at(problem: SignatureFit) -> float:
    """Return the number of fits that a reference fit compares: every start and length, tau and omega of its scan."""
    return len(problem.time) * max(problem.period / 2 / problem.dt, 1.0) * TAUS * OMEGAS
