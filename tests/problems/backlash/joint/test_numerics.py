"""Accuracy of the integration, the encoder, the shapes, and what is refused."""

from dataclasses import astuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.stats import kstest

from bench.helpers.errors import BenchError
from problems.backlash.joint import DEFAULT, half_gap, simulate, with_noise
from problems.backlash.joint.simulator import derivative, resting_state

FINEST = 2e-6  # s


def by_scipy(level, rtol, atol):
    """The speed of level's first 0.8 s, as `simulate(duration=0.8)` gives it, by scipy's LSODA."""
    delta = half_gap(level)
    theta0 = 0.141 - DEFAULT.drive.omega_ref / DEFAULT.gear.gear_ratio * 1.2

    def rate(t, state):
        out = np.empty(5)
        derivative(t, state, astuple(DEFAULT), delta, theta0, out)
        return out

    start = resting_state(DEFAULT, delta, theta0)
    times = np.minimum(1.2 + np.arange(401) / 500, 2.0)
    options = {"method": "LSODA", "rtol": rtol, "atol": atol, "max_step": 1e-3}
    return 100 + solve_ivp(rate, (0, 2.0), start, t_eval=times, **options).y[1] / (2 * np.pi)


@pytest.mark.parametrize(("level", "rtol", "atol"), [(3, 1e-6, 1e-9), (12, 1e-9, 1e-12)])
def test_agrees_with_scipy(level, rtol, atol):
    finest = simulate(half_gap=half_gap(level), duration=0.8, step=FINEST)
    assert finest.speed == pytest.approx(by_scipy(level, rtol, atol), abs=1e-5)


def test_largest_step_is_stable():
    coarse = simulate(half_gap=half_gap(8), step=1e-3)
    assert np.max(np.abs(coarse.speed - 100)) < 1.5


def test_encoder_adds_its_quantisation_and_lags_half_a_sample(simulated):
    exact, coded = simulated(12), simulate(half_gap=half_gap(12), encoder_bits=19)
    assert coded.speed.shape == exact.speed.shape
    counts = coded.speed * 2**19 / 500
    assert counts == pytest.approx(np.round(counts), abs=1e-6)
    fine = exact.fine
    angle = np.concatenate([[0], np.cumsum(fine.speed[1:] + fine.speed[:-1]) / 2 * 5e-5])  # turns
    added = coded.speed[1:] - np.diff(angle[::40]) * 500
    assert np.std(added) == pytest.approx(4e-4, rel=0.1)
    assert abs(np.mean(added)) < 5e-5
    lags = np.arange(0, 2.0e-3, 5e-5)
    errors = [np.std(coded.speed[5:] - np.interp(exact.time[5:] - lag, fine.time, fine.speed)) for lag in lags]
    assert lags[np.argmin(errors)] == pytest.approx(1e-3, abs=6e-5)


def test_the_step_divides_any_sampling_period_and_settles_to_the_nearest_step():
    odd = simulate(half_gap=0.001, rate=333.0, duration=0.4)
    assert np.diff(odd.fine.time)[0] == pytest.approx(1 / 333 / 61)  # 60 would be longer than 5e-5 s
    fine = simulate(half_gap=0.001, rate=20_000.0, duration=0.4)
    np.testing.assert_allclose(odd.speed, np.interp(odd.time, fine.time, fine.speed), atol=2e-3)
    late = simulate(half_gap=0.001, duration=0.4, settle=1.20002)  # 24000.4 steps
    np.testing.assert_array_equal(late.speed, simulate(half_gap=0.001, duration=0.4).speed)


def test_noise_is_uniform_white_and_of_the_peak_to_peak_value_asked_for():
    noise = with_noise(np.full(50_000, 100.0), 0.3, np.random.default_rng(0)) - 100
    assert kstest(noise, "uniform", (-0.15, 0.3)).pvalue > 0.01
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.02
    for bad in (-0.1, float("nan"), float("inf")):
        with pytest.raises(BenchError, match="noise"):
            with_noise(np.zeros(3), bad, np.random.default_rng(0))
