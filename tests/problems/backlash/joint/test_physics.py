"""What a correct simulator shows: poles, gap openings, impacts and peaks of the identified joint."""

from dataclasses import astuple

import numpy as np
import pytest

from problems.backlash.joint import DEFAULT, half_gap, load_joint, simulate
from problems.backlash.joint.simulator import derivative, gap_torque, integrate, resting_state

PEAKS = [
    0.115, 0.276, 0.406, 0.518, 0.618, 0.710, 0.797, 0.880, 0.960, 1.037,
    1.111, 1.184, 1.256, 1.326, 1.396, 1.464, 1.531, 1.598, 1.664, 1.731,
]  # rps, levels 1 to 20; identified on the published recordings  # fmt: skip
TABLE_7_3 = [0.2769, 0.4159, 0.5245, 0.6263, 0.7246, 0.8162, 0.8976, 0.9757, 1.0639, 1.1385]  # rps, levels 2 to 11


def poles(dtheta, delta):
    """Eigenvalues of the simulator's own right-hand side without gravity, linearised numerically at dtheta."""
    constants = astuple(load_joint(gravity_torque=0.0))
    point, small = np.array([0, 0, -dtheta, 0, 0.0]), np.array([1e-6, 1e-3, 1e-8, 1e-5, 1e-6])
    jacobian, high, low = np.empty((5, 5)), np.empty(5), np.empty(5)
    for j, step in enumerate(small):
        shift = step * np.eye(5)[j]
        derivative(0.0, point + shift, constants, delta, 0.0, high)
        derivative(0.0, point - shift, constants, delta, 0.0, low)
        jacobian[:, j] = (high - low) / (2 * step)
    return np.linalg.eigvals(jacobian)


def crossings(fine, delta):
    """Indices (opening, impact) of every passage through the gap from one flank to the other."""
    side = np.where(fine.dtheta >= delta, 1, np.where(fine.dtheta <= -delta, -1, 0))
    contact = np.flatnonzero(side)
    flips = np.flatnonzero(side[contact[:-1]] != side[contact[1:]])
    return contact[flips] + 1, contact[flips + 1]


@pytest.mark.parametrize("delta", [0.0, 0.0005, 0.0039])
def test_poles_in_contact_whatever_the_gap(delta):
    expected = [-644 + 498j, -644 - 498j, -29.8, -15.6 + 133.5j, -15.6 - 133.5j]
    found = poles(dtheta=delta + 1e-3, delta=delta)
    for pole in expected:
        assert np.min(np.abs(found - pole)) < 1.5e-3 * abs(pole)


def test_poles_with_the_gap_open():
    found = poles(dtheta=5e-4, delta=2e-3)
    for pole in (-421 + 213j, -421 - 213j, -30.8):
        assert np.min(np.abs(found - pole)) < 2e-3 * abs(pole)
    assert np.sort(found.real)[-2] > -0.1  # the load is all but free: what is left to hold it is the finite alpha


def test_stiffness_and_torque_of_the_gap():
    gear = DEFAULT.gear
    laws = (0.001, gear.stiffness, gear.damping, gear.sharpness)
    assert gap_torque(0.002, 0.1, *laws) == pytest.approx(gear.stiffness * 0.001 + gear.damping * 0.1, rel=1e-3)
    assert gap_torque(-0.002, 0.0, *laws) == pytest.approx(-gear.stiffness * 0.001, rel=1e-3)
    assert abs(gap_torque(0.0005, 0.0, *laws)) < 0.02
    # The known flaw of eq. (4.6) at finite alpha: at dtheta = 0 the torque jumps and opposes the twist.
    assert gap_torque(1e-12, 0.0, *laws) == pytest.approx(-0.026, abs=1e-3)
    assert gap_torque(-1e-12, 0.0, *laws) == pytest.approx(0.026, abs=1e-3)


@pytest.mark.parametrize("level", [3, 8, 13, 20])
def test_two_opposite_oscillations_a_load_turn(simulated, level):
    fine = simulated(level).fine
    opening, impact = crossings(fine, half_gap(level))
    assert np.diff(fine.time[impact]) == pytest.approx(0.2, abs=1e-3)
    assert np.all(np.sign(np.gradient(fine.dtheta, fine.time)[impact]) == np.where(np.arange(len(impact)) % 2, 1, -1))
    assert len(opening) == 23  # the 24th of the twelve turns opens before the recording ends and closes after
    turn = fine.speed[:8000] - 100
    assert np.corrcoef(turn[:4000], turn[4000:])[0, 1] < -0.998


@pytest.mark.parametrize("level", [3, 8, 13, 20])
def test_gap_opens_where_gravity_torque_vanishes(simulated, level):
    fine = simulated(level).fine
    opening, _ = crossings(fine, half_gap(level))
    assert np.max(np.abs(np.sin(fine.load_angle[opening]))) < 0.075


@pytest.mark.parametrize(
    ("level", "flight", "speed"), [(3, 0.0192, 0.11), (8, 0.0296, 0.24), (13, 0.0339, 0.34), (20, 0.0369, 0.47)]
)
def test_time_from_opening_to_impact_and_speed_of_impact(simulated, level, flight, speed):
    fine = simulated(level).fine
    opening, impact = crossings(fine, half_gap(level))
    assert fine.time[impact] - fine.time[opening] == pytest.approx(flight, abs=2e-4)
    assert np.abs(np.gradient(fine.dtheta, fine.time)[impact]) == pytest.approx(speed, abs=0.007)


def test_peaks_of_all_levels(simulated):
    peaks = np.array([simulated(level).peak for level in range(1, 21)])
    assert peaks == pytest.approx(np.array(PEAKS), rel=2.5e-3)
    gaps = np.array([half_gap(level) for level in range(2, 21)])
    assert np.polyfit(np.log(gaps), np.log(peaks[1:]), 1)[0] == pytest.approx(0.71, abs=0.005)


def test_peaks_near_the_theoretical_amplitudes_of_table_7_3(simulated):
    peaks = np.array([simulated(level).peak for level in range(2, 12)])
    assert peaks == pytest.approx(np.array(TABLE_7_3), rel=0.03)  # 0.5 to 2.6 % below


def test_without_gap_a_smooth_gravity_ripple():
    simulation = simulate(half_gap=0.0)
    deviation = simulation.fine.speed - 100
    assert deviation.max() == pytest.approx(0.054, abs=5e-4)
    assert deviation.min() == pytest.approx(-0.054, abs=5e-4)
    harmonics = np.abs(np.fft.rfft(deviation[:96000])) / 48000  # whole turns: every 12th is one of the load's turn
    assert harmonics[12] == pytest.approx(0.054, abs=5e-4)
    assert np.sqrt(np.sum(np.delete(harmonics, 12) ** 2)) < 2e-4


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("level", [3, 20])
def test_parallel_to_gravity_a_disturbance_dies_at_any_gap(level, friction):
    def last_turn(joint):
        """Speed deviation of the last of 12 turns after a push inside the gap."""
        push = resting_state(joint, half_gap(level), 0.0)
        push[1:4] = 5.0, 0.5 * half_gap(level), 0.05
        states = integrate(push, astuple(joint), half_gap(level), 0.0, 5e-5, 0, 96000)
        return np.max(np.abs(states[-8000:, 1])) / (2 * np.pi)

    assert last_turn(load_joint(gravity_torque=0.0, coulomb_friction=friction)) < 1e-6
    assert last_turn(load_joint(coulomb_friction=friction)) > 0.4


def test_shock_damping_holds_the_peak_down(simulated):
    growth = [
        simulate(load_joint(damping=0.0), half_gap=half_gap(k), duration=0.4).peak / simulated(k).peak for k in (3, 13)
    ]
    assert min(growth) > 1.10
    assert max(growth) < 1.18


def test_another_reference_speed_moves_the_whole_signal():
    joint = load_joint(omega_ref=2 * np.pi * 50)
    simulation = simulate(joint, half_gap=half_gap(8), duration=1.6, encoder_bits=19)
    assert np.mean(simulation.speed[:400]) == pytest.approx(50, abs=0.01)
    assert np.mean(simulation.fine.speed) == pytest.approx(50, abs=0.01)
    _, impact = crossings(simulation.fine, half_gap(8))
    assert np.diff(simulation.fine.time[impact]) == pytest.approx(0.4, abs=2e-3)
    assert 0.1 < simulation.peak < 2
