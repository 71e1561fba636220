"""The simulator against the thesis authors' own simulated recordings."""

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import least_squares

from problems.backlash.joint import DEFAULT, half_gap, load_joint, simulate

LEVELS = [3, 5, 8, 11, 12]


def over_a_turn(speed):
    """Mean over the twelve load turns: (2401,) at 500 Hz to (200,)."""
    return speed[:2400].reshape(12, 200).mean(axis=0)


@pytest.fixture(scope="module")
def recorded(published):
    def read(level):
        return pd.read_excel(published / f"Speeddata{level}.xlsx", engine="openpyxl").to_numpy()[:, 1]

    return {level: over_a_turn(read(level)) for level in LEVELS}


def nrmse(recorded, joint, level):
    model = over_a_turn(simulate(joint, half_gap=half_gap(level)).speed)
    return np.sqrt(np.mean((model - recorded[level]) ** 2)) / np.std(recorded[level])


@pytest.mark.parametrize("level", LEVELS)
def test_reproduces_the_recordings(recorded, level):
    assert nrmse(recorded, DEFAULT, level) < 0.07


@pytest.mark.parametrize(
    ("change", "level", "low", "high"),
    [
        ({"sharpness": 1e4}, 8, 0.50, 0.60),
        ({"sharpness": 3e4}, 8, 0.20, 0.24),
        ({"sharpness": 3e5}, 8, 0.04, 0.06),
        ({"position_gain": 0.0}, 5, 0.50, 0.66),
        ({"position_gain": 0.0}, 12, 0.53, 0.66),
        ({"integral_gain": 0.0}, 8, 2.0, 4.0),
        ({"coulomb_friction": 0.5}, 8, 0.4, 0.5),
        ({"coulomb_friction": 0.5}, 12, 0.4, 0.5),
    ],
)
def test_every_term_is_needed(recorded, change, level, low, high):
    assert low < nrmse(recorded, load_joint(**change), level) < high


def oscillation(turn, first):
    """Fit A exp(-tau (t - t[first])) sin(omega (t - t0)) from sample first of the half turn on: (RMSE, A), rps."""
    signal, t = (turn[:100] - turn[100:]) / 2, 0.002 * np.arange(100)  # the two half turns are opposite

    def residual(x):
        A, t0, tau, omega = x
        model = A * np.exp(-tau * (t - t[first])) * np.sin(omega * (t - t0))
        return np.where(t >= t[first], model, 0.0) - signal

    start = [-np.max(np.abs(signal)), t[first] - 0.010, 15.6, 133.5]
    fit = least_squares(residual, start, x_scale=[1, 0.01, 10, 100])
    return np.sqrt(2 * fit.cost / 100), fit.x[0]


@pytest.mark.parametrize("level", LEVELS)
def test_signature_fits_agree_with_those_of_the_recordings(recorded, simulated, level):
    # A depends on where the oscillation starts, so amplitudes are compared for the start that suits the recording best.
    model = over_a_turn(simulated(level).speed)
    fits = [(*oscillation(recorded[level], first), *oscillation(model, first)) for first in range(2, 17)]
    rmse, amplitude, _, model_amplitude = min(fits)
    assert min(fit[2] for fit in fits) == pytest.approx(rmse, abs=0.003)
    assert model_amplitude == pytest.approx(amplitude, rel=0.02)
