"""An estimate is close to the truth of simulated recordings, and states nothing that it cannot know."""

import numpy as np
import pytest

from problems.backlash.joint import load_joint, simulate
from problems.backlash.recordings import Recording
from problems.backlash.sensor import evidence
from problems.backlash.sensor.estimate import Settings, estimate, signature_problem
from problems.backlash.signature.datasets import noisy
from tests.problems.backlash.cut import cut

PLAIN = Settings(resamples=0)


def noise(seed, size=2401, colour=0.0):
    drawn = 0.2 * np.random.default_rng(seed).uniform(-0.5, 0.5, size)
    return np.convolve(drawn, colour ** np.arange(30), "same")


@pytest.mark.parametrize(
    ("level", "strength", "verdict"),
    [(2, "low", "early"), (8, "high", "early"), (11, "low", "early"), (14, "high", "progressed")],
)
def test_levels_with_noise_are_measured(level, strength, verdict):
    made = noisy(level, strength, draw=3)
    found = estimate(made, PLAIN)
    assert found.amplitude_rps == pytest.approx(made.peak, rel=0.1)
    assert found.backlash_rad == pytest.approx(made.half_gap, abs=2e-4)
    assert found.verdict == verdict
    assert found.fit.period_s == pytest.approx(0.4, abs=1e-9)
    assert found.fit.period_source == "signal"
    assert found.p_value < 1e-30


@pytest.mark.slow
@pytest.mark.parametrize("colour", [0.0, 0.8], ids=["white", "coloured"])
def test_noise_alone_is_no_backlash(colour):
    for seed in range(2):
        found = estimate(Recording(0.0, 0.002, 100 + noise(seed, colour=colour)))
        assert found.verdict == "no backlash"
        assert (found.amplitude_rps, found.backlash_rad) == (0.0, 0.0)
        assert 0.0 < found.amplitude_interval_rps[1] < 0.2  # what could have been detected
        assert 1e-4 <= found.interval_rad[1] < 4e-4
        assert found.p_value > evidence.SIGNIFICANT
        assert "no period was found" in " ".join(found.notes)


@pytest.mark.slow
def test_the_ripple_of_a_joint_without_backlash_is_none():
    ripple = simulate(half_gap=0.0).speed
    for speed in (ripple, ripple + noise(1)):
        found = estimate(Recording(0.0, 0.002, speed), PLAIN)
        assert found.verdict == "no backlash"
        assert found.p_value > evidence.SIGNIFICANT
        assert found.interval_rad[1] < 2e-4


@pytest.mark.slow
def test_what_could_have_been_told_can_be_told():
    quiet = Recording(0.0, 0.002, 100 + noise(5))
    problem = signature_problem(quiet, Settings(), 0.4)
    most = evidence.detectable(problem)
    t0, tau, omega, t1 = evidence.BENCH
    wave = problem.model(np.array([1.0, 0.05 + t0, tau, omega, 0.0, t1, 0.2]))
    found = [
        estimate(Recording(0.0, 0.002, quiet.speed + factor * most * wave), Settings(gear_ratio=40.0, resamples=0))
        for factor in (0.3, 2.0)
    ]
    assert [each.p_value <= evidence.SIGNIFICANT for each in found] == [False, True]
    assert found[1].amplitude_rps == pytest.approx(2 * most, rel=0.4)


def test_intervals_hold_the_truth_and_grow_with_the_noise():
    widths = []
    for strength in ("low", "high"):
        made = noisy(9, strength, draw=1)
        found = estimate(made, Settings(resamples=60))
        low, high = found.amplitude_interval_rps
        assert low < made.peak < high
        assert low < found.amplitude_rps < high
        assert found.interval_rad[0] < made.half_gap < found.interval_rad[1]
        fits = evidence.resampled(
            signature_problem(made, Settings(), 0.4),
            np.array(list(found.fit.variables.values())),
            40,
            np.random.default_rng(0),
        )
        widths.append(np.abs(fits[:, 0]).std())
    assert widths[1] > 1.2 * widths[0]


@pytest.mark.slow
def test_one_oscillation_is_measured_too_and_so_is_one_beside_another():
    speed = simulate(half_gap=0.0015).speed + noise(2)
    for last in (100, 250):
        found = estimate(Recording(18.99, 0.002, speed[:last]), Settings(single=True, resamples=0))
        assert found.amplitude_rps == pytest.approx(0.88, rel=0.15)
        assert found.verdict == "early"
        assert found.notes == ()
    quiet = estimate(Recording(18.99, 0.002, 100 + noise(3, 300)), Settings(single=True))
    assert quiet.verdict == "no backlash"


def test_an_amplitude_beyond_the_calibration_gets_no_backlash():
    made = noisy(20)
    turn = np.exp(2j * np.pi * made.time / 0.4)
    ripple = 2 * (np.mean((made.speed - 100) * turn.conj()) * turn).real
    louder = Recording(made.start, made.dt, 100 + 3 * (made.speed - 100) - 2 * ripple)
    found = estimate(louder, PLAIN)
    assert np.isnan(found.backlash_rad)
    assert found.verdict == "progressed"
    assert "outside the calibrated range" in " ".join(found.notes)


def test_a_drift_of_the_mean_speed_hides_no_backlash():
    made = noisy(10)
    drifting = Recording(made.start, made.dt, made.speed + np.linspace(0, 2.4, len(made.speed)))
    found = estimate(drifting, PLAIN)
    assert found.amplitude_rps == pytest.approx(made.peak, rel=0.1)
    assert "drifts by 2.4" in " ".join(found.notes)


def test_an_interval_that_contains_the_limit_leaves_the_verdict_open():
    made = noisy(8)
    found = estimate(made, Settings(resamples=50))
    assert found.verdict == "early"
    for limit, verdict in ((sum(found.interval_rad) / 2, "undecided"), (found.interval_rad[0] / 1.01, "progressed")):
        again = estimate(made, Settings(resamples=50, limit_rad=limit))
        assert again.verdict == verdict
        assert any("contains the limit" in note for note in again.notes) == (verdict == "undecided")
        assert again.interval_rad == found.interval_rad


@pytest.mark.slow
@pytest.mark.parametrize(
    ("joint", "settings", "differs"),
    [
        ({"gear_ratio": 80.0}, {"gear_ratio": 80.0}, "a gear ratio of 80, not 40"),
        ({"gear_ratio": 60.0}, {}, "a gear ratio of 60, not 40"),
        ({"omega_ref": 2 * np.pi * 60}, {}, "a motor speed of 60 rps, not 100"),
        ({"omega_ref": 2 * np.pi * 98.5}, {"gear_ratio": 40.0}, "a motor speed of 98.5 rps, not 100"),
        ({"omega_ref": 2 * np.pi * 99.2}, {}, None),
        ({"gear_ratio": 40.3}, {"gear_ratio": 40.3}, None),
    ],
)
def test_a_calibration_of_another_joint_or_speed_gives_no_half_gap_and_no_verdict(joint, settings, differs):
    made = load_joint(**joint)
    speed = simulate(made, half_gap=0.0023, duration=12 * made.turn).speed
    found = estimate(Recording(0.0, 0.002, speed), Settings(resamples=0, **settings))
    if differs is None:
        assert found.verdict == "progressed"
        assert found.backlash_rad == pytest.approx(0.0023, abs=1e-4)
        assert found.notes == ()
        return
    assert (found.verdict, found.calibration) == ("backlash", "")
    assert np.isnan(found.backlash_rad)
    (note,) = found.notes
    assert differs in note
    assert "bench calibrate --joint" in note


def test_a_recording_in_which_any_disturbance_could_hide_is_undecided_without_a_calibration():
    short = estimate(cut(noisy(12), 0.0, 0.298), Settings(calibration=None, gear_ratio=13.2, resamples=0))
    assert (short.verdict, short.amplitude_rps) == ("undecided", 0.0)
    quiet = estimate(noisy(0), Settings(calibration=None, gear_ratio=40.0, resamples=0))
    assert (quiet.verdict, quiet.amplitude_rps) == ("no backlash", 0.0)
