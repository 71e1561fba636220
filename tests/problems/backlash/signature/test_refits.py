"""Fits near a known one are those that the exhaustive search finds."""

import numpy as np
import pytest

from problems.backlash.recordings import Recording
from problems.backlash.sensor.evidence import resampled
from problems.backlash.signature.datasets import noisy
from problems.backlash.signature.model import OMEGA, TAU, A
from problems.backlash.signature.problem import SignatureFit
from tests.problems.backlash.cut import cut


def resamples(problem, x, count, seed=0):
    """Return the fit of a problem plus noise as strong as its residuals, (count, N)."""
    fitted = problem.model(x)
    noise = np.random.default_rng(seed).normal(size=(count, len(fitted)))
    return fitted + (problem.signal - fitted).std() * noise


@pytest.mark.slow
@pytest.mark.parametrize(
    "options", [{}, {"period": 0.40005}, {"single": True}], ids=["box", "T_d between samples", "single"]
)
def test_a_refit_is_the_reference_fit_of_its_signal(options):
    problem = SignatureFit("refit", cut(noisy(12), 0.0, 2.4 if "single" not in options else 0.5), **options)
    x = problem.reference().x
    signals = resamples(problem, x, 3)
    for signal, found in zip(signals, problem.near(x, signals), strict=True):
        other = problem.beside(signal)
        value = float(other.evaluate(found[np.newaxis])[0])
        assert value == pytest.approx(other.reference().value, rel=2e-3)
        assert (problem.lower <= found).all()
        assert (found <= problem.upper).all()


def test_refits_find_tau_and_omega_far_better_than_they_scatter():
    """The nine points end at steps of 0.016 1/s and 0.03 rad/s, the paraboloid through them is much closer."""
    problem = SignatureFit("fine", noisy(12))
    x = problem.reference().x
    signals = resamples(problem, x, 40)
    found = problem.near(x, signals)
    best = np.array([problem.beside(signal).reference().x for signal in signals[:8]])
    near = np.isclose(best[:, OMEGA], found[:8, OMEGA], atol=0.3)  # two maxima may be nearly as high
    assert near.sum() >= 7
    for variable in (A, TAU, OMEGA):
        off = np.abs(best - found[:8])[near, variable]
        assert off.max() < 0.01 * found[:, variable].std()


def test_a_window_at_the_recording_s_end_is_refitted():
    speed = 100 + np.random.default_rng(0).uniform(-0.1, 0.1, 300)
    speed[-3:] += [1.0, -1.0, 1.0]
    problem = SignatureFit("late", Recording(0.0, 0.002, speed), single=True)
    fits = resampled(problem, problem.reference().x, 3, np.random.default_rng(0))
    assert np.isfinite(fits).all()
