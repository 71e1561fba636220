"""Accuracy of the integration, the encoder, the shapes, and what is refused."""

from dataclasses import astuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.stats import kstest

from bench.errors import BenchError
from problems.backlash.joint import Joint, half_gap, simulate, with_noise
from problems.backlash.joint.simulator import derivative, resting_state

FINEST = 2e-6  # s


def by_scipy(level, rtol, atol):
    """The speed of level's first 0.8 s, as `simulate(duration=0.8)` gives it, by scipy's LSODA."""
    joint, delta = Joint(), half_gap(level)
    theta0 = 0.141 - joint.omega_ref / joint.gear_ratio * 1.2

    def rate(t, state):
        out = np.empty(5)
        derivative(t, state, astuple(joint), delta, theta0, out)
        return out

    start = resting_state(joint, delta, theta0)
    times = np.minimum(1.2 + np.arange(401) / 500, 2.0)
    options = {"method": "LSODA", "rtol": rtol, "atol": atol, "max_step": 1e-3}
    return 100 + solve_ivp(rate, (0, 2.0), start, t_eval=times, **options).y[1] / (2 * np.pi)


@pytest.mark.parametrize(("level", "rtol", "atol"), [(3, 1e-6, 1e-9), (12, 1e-9, 1e-12)])
def test_agrees_with_scipy(level, rtol, atol):
    finest = simulate(half_gap=half_gap(level), duration=0.8, step=FINEST)
    assert finest.speed == pytest.approx(by_scipy(level, rtol, atol), abs=1e-5)


@pytest.mark.parametrize(("level", "error"), [(2, 6e-5), (11, 6e-5), (3, 1e-4), (12, 7e-4), (19, 2.1e-3)])
def test_error_of_the_default_step(simulated, level, error):
    # An impact is shorter than a step, so the error depends on where in a step it falls; 19 is the worst of 1 to 20.
    finest = simulate(half_gap=half_gap(level), duration=0.8, step=FINEST)
    assert np.max(np.abs(simulated(level).speed[:401] - finest.speed)) < error


def test_largest_step_is_stable():
    coarse = simulate(half_gap=half_gap(8), step=1e-3)
    assert np.max(np.abs(coarse.speed - 100)) < 1.5


def test_shapes_and_sampling(simulated):
    simulation = simulated(8)
    assert simulation.time.shape == simulation.speed.shape == (2401,)
    assert simulation.time[[0, 1, -1]] == pytest.approx([0, 0.002, 4.8])
    fine = simulation.fine
    assert {signal.shape for signal in vars(fine).values()} == {(96001,)}
    assert np.array_equal(fine.speed[::40], simulation.speed)
    assert fine.load_angle[0] == pytest.approx(0.141, abs=0.005)
    assert simulation.peak == fine.speed[-8000:].max() - 100
    assert len(simulate(half_gap=0.001, duration=0.1, rate=1000).speed) == 101


def test_start_angle_shifts_the_recording_in_time(simulated):
    turn_by_80_ms = 2 * np.pi * 100 / 40 * 0.08
    shifted = simulate(half_gap=half_gap(8), start_angle=0.141 + turn_by_80_ms)
    assert shifted.speed[:2361] == pytest.approx(simulated(8).speed[40:], abs=1e-3)


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


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        ({"half_gap": float("nan")}, "half_gap"),
        ({"duration": 0.0}, "duration"),
        ({"rate": float("inf")}, "rate"),
        ({"settle": -1.0}, "settle"),
        ({"duration": 199.0}, "at most 200 s"),
        ({"step": 3e-5}, "divide the sampling period"),
        ({"rate": 100.0, "step": 2e-3}, "at most 0.001 s"),
        ({"rate": 1e6}, "at most 4 s"),
        ({"start_angle": float("inf")}, "start_angle"),
        ({"encoder_bits": 12.5}, "encoder_bits"),
        ({"encoder_bits": 19, "settle": 0.0}, "settle"),
    ],
)
def test_refuses_bad_arguments(bad, message):
    with pytest.raises(BenchError, match=message) as caught:
        simulate(**{"half_gap": 0.001, **bad})
    assert "\n" not in str(caught.value)


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


def test_a_stiffer_joint_needs_a_smaller_step():
    with pytest.raises(BenchError, match="diverges with a step"):
        simulate(Joint(stiffness=1e8, damping=1e4), half_gap=0.001)
