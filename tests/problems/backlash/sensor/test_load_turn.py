"""Impacts, steady tones and noise are distinguished in the harmonics of a load turn, and T_d is found in them."""

import numpy as np
import pytest

from problems.backlash.joint import DEFAULT, load_joint, simulate
from problems.backlash.recordings import Recording
from problems.backlash.sensor.estimate import Settings, estimate
from problems.backlash.sensor.evidence import SIGNIFICANT
from problems.backlash.sensor.load_turn import fold, halves
from problems.backlash.signature.model import signature

TIME = 0.002 * np.arange(2401)
RATIO = Settings(gear_ratio=40.0, resamples=0)


def recorded(speed, seed=1, noise=0.2):
    return Recording(0.0, 0.002, speed + noise * np.random.default_rng(seed).uniform(-0.5, 0.5, len(speed)))


def worn(gap, friction=0.0):
    return simulate(load_joint(coulomb_friction=friction * DEFAULT.load.gravity_torque), half_gap=gap).speed


@pytest.fixture(scope="module")
def healthy():
    return simulate(half_gap=0.0).speed


@pytest.mark.parametrize("friction", [0.02, 0.07, 0.14, 0.35])
@pytest.mark.parametrize("gap", [0.0007, 0.0015])
def test_friction_moves_one_impact_towards_the_other(friction, gap):
    turn = fold(recorded(worn(gap, friction)), 0.4)
    assert turn.impacting
    assert turn.impacts.delay == pytest.approx(0.5 - np.arcsin(friction) / np.pi, abs=0.012)
    assert turn.friction == pytest.approx(friction, abs=0.035)


def test_the_two_parts_of_a_load_turn_have_their_impacts_evenly_apart():
    x = np.array([0.5, 0.03, 15.0, 134.0, 0.0, 0.011, 0.15])
    speed = 100 + sum(
        signature(TIME - late, x * sign, period=9.0, replicas=1)
        for turn in range(12)
        for late, sign in ((0.4 * turn, [1, 1, 1, 1, 0, 1, 1]), (0.4 * turn + 0.17, [-1, 1, 1, 1, 0, 1, 1]))
    )
    made = recorded(speed, noise=0.0)
    parts = halves(made, fold(made, 0.4))
    assert parts.length == pytest.approx(0.17, abs=1e-3)
    joined = parts.joined.speed.reshape(-1, round(parts.length / parts.joined.dt)) - 100
    signs = np.sign(joined[:, np.abs(joined[0]).argmax()])
    assert (signs[1:] == -signs[:-1]).all()
    np.testing.assert_allclose(
        joined[1:-1] * signs[1:-1, None], np.tile(joined[1] * signs[1], (len(joined) - 2, 1)), atol=0.03
    )


def test_a_joint_with_friction_is_undecided_by_a_calibration_without_and_is_never_healthy():
    for friction in (0.14, 0.35):
        found = estimate(recorded(worn(0.0015, friction)), RATIO)
        assert found.verdict == "undecided"
        assert np.isnan(found.backlash_rad)
        assert "friction of" in found.notes[-1]
        assert found.fit.explained > 0.8
    slight = estimate(recorded(worn(0.0015, 0.02)), RATIO)
    assert slight.verdict == "early"
    assert slight.backlash_rad == pytest.approx(0.0015, rel=0.05)


@pytest.mark.parametrize("frequency", [3.0, 7.5, 17.0, 22.5, 21.3, 50.0])
@pytest.mark.parametrize("settings", [RATIO, Settings(resamples=0)], ids=["ratio", "no ratio"])
@pytest.mark.slow
def test_a_steady_tone_is_no_backlash(healthy, frequency, settings):
    found = estimate(recorded(healthy + 0.8 * np.sin(2 * np.pi * frequency * TIME)), settings)
    assert found.verdict in ("no backlash", "undecided")


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.slow
def test_harmonics_of_the_load_turn_are_no_backlash(healthy, seed):
    rng = np.random.default_rng(seed)
    for numbers in (rng.integers(1, 21, 1), rng.choice(20, 4, replace=False) + 1, np.arange(1, 20, 2)):
        waves = np.sin(2 * np.pi * np.outer(TIME, numbers) / 0.4 + rng.uniform(0, 6.28, len(numbers)))
        assert estimate(recorded(healthy + 0.1 * waves.sum(axis=1)), RATIO).verdict in ("no backlash", "undecided")


def test_halves_of_unlike_size_are_asymmetric():
    speed = worn(0.0015) - 100
    lopsided = np.where((TIME % 0.4) < 0.2, speed, 0.15 * speed)
    found = estimate(recorded(100 + lopsided), RATIO)
    assert found.verdict == "undecided"
    assert "asymmetric" in found.notes[-1]


def test_resonant_noise_is_noise(healthy):
    rng = np.random.default_rng(4)
    for quality in (3, 30):
        pole = np.exp(0.002 * 2 * np.pi * 22 * (-0.5 / quality + 1j))
        noise, state = np.empty(2401, dtype=complex), 0j
        for i, drawn in enumerate(rng.standard_normal(2401)):
            noise[i] = state = pole * state + drawn
        turn = fold(recorded(healthy + 0.1 * noise.real / noise.real.std()), 0.4)
        assert turn.p_value > SIGNIFICANT


def test_the_smallest_amplitude_that_noise_hides_is_detected_when_doubled():
    quiet = recorded(np.full(2401, 100.0))
    turn = fold(quiet, 0.4)
    usual = np.array([1.0, 0.05, 15.6, 133.5, 0.0, 0.0118, 0.2])
    wave = turn.detectable * signature(TIME, usual, period=0.4, replicas=24)
    found = [fold(Recording(0.0, 0.002, quiet.speed + factor * wave), 0.4) for factor in (0.3, 2.0)]
    assert [each.p_value <= SIGNIFICANT for each in found] == [False, True]
    assert found[1].amplitude == pytest.approx(2 * turn.detectable, rel=0.2)
