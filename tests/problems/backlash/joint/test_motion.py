"""A joint that turns back and forth between two ends, as a robot's wrist does (thesis sections 3.2 and 8.3)."""

from functools import cache
from math import pi

import numpy as np
import pytest

from problems.backlash.joint import load_joint, simulate

WRIST = load_joint(speed_rps=20.0)  # half a load turn a second
RAMP, STROKE = 0.3, 1.4  # s: 4.4 rad in each direction, gravity's lowest point in the middle


@cache
def moved(half_gap, joint=WRIST, **options):
    options = {"sweep": pi * STROKE, "ramp": RAMP, "start_angle": -pi * STROKE / 2, "settle": 0.0} | options
    return simulate(joint, half_gap=half_gap, duration=2 * (STROKE + RAMP), **options)


def test_the_load_turns_forth_and_back():
    fine = moved(0.0).fine
    assert np.ptp(fine.load_angle) == pytest.approx(pi * STROKE, abs=2e-3)
    assert fine.load_angle[[0, -1]] == pytest.approx([-pi * STROKE / 2] * 2, abs=2e-3)
    assert fine.reference.max() == pytest.approx(20)
    assert fine.reference.min() == pytest.approx(-20)
    assert np.max(np.abs(fine.speed - fine.reference)) < 0.3


def test_position_is_the_integral_of_the_speed():
    for made in (moved(0.001), simulate(half_gap=0.001, duration=0.8)):
        fine = made.fine
        step = fine.time[1]
        integral = 2 * pi * step * np.cumsum((fine.speed[1:] + fine.speed[:-1]) / 2)
        assert np.max(np.abs(fine.position[1:] - fine.position[0] - integral)) < 1e-3
        assert made.position == pytest.approx(fine.position[:: len(fine.time) // (len(made.time) - 1)])


def test_an_encoder_s_position_is_in_whole_counts():
    coded, exact = (simulate(half_gap=0.001, duration=0.4, encoder_bits=bits) for bits in (12, None))
    counts = coded.position / (2 * pi) * 2**12
    assert counts == pytest.approx(np.round(counts), abs=1e-6)
    assert np.max(np.abs(coded.position - exact.position)) < 2 * 2 * pi / 2**12


def test_a_gap_shows_only_where_the_speed_is_constant():
    """Section 3.2: not where the motion reverses, although the motor starts and stops there."""
    healthy, worn = moved(0.0).fine, moved(0.001).fine
    made_by_gap = np.abs(worn.speed - healthy.speed)
    steady = np.abs(healthy.reference) > 20 - 1e-9
    assert made_by_gap[steady].max() > 0.35
    assert made_by_gap[~steady].max() < 0.01
    assert np.abs(healthy.speed - healthy.reference)[~steady].max() > 0.05  # the ramps' own ripple hides that


def test_one_oscillation_each_way_of_opposite_sign():
    fine = moved(0.001).fine
    deviation = fine.speed - fine.reference
    forth, back = fine.reference > 20 - 1e-9, fine.reference < -20 + 1e-9
    late = np.abs(fine.load_angle) < 1.0  # the ramps' ripple has died away
    first, second = (deviation[way & late] for way in (forth, back))
    assert first[np.argmax(np.abs(first))] * second[np.argmax(np.abs(second))] < 0
    assert moved(0.001).peak == pytest.approx(np.abs(np.concatenate([first, second])).max())
