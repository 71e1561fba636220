from dataclasses import FrozenInstanceError, fields
from math import pi

import pytest

from bench.errors import BenchError
from problems.backlash.joint import Joint, half_gap


def test_half_gaps_of_the_twenty_levels():
    assert half_gap(1) == 0.0001
    assert half_gap(2) == 0.0003
    assert half_gap(12) == 0.0023
    assert half_gap(20) == 0.0039


@pytest.mark.parametrize("level", [0, 21, -1, 2.5, "3"])
def test_half_gap_refuses_other_levels(level):
    with pytest.raises(BenchError, match="from 1 to 20"):
        half_gap(level)


def test_joint_is_frozen_and_keeps_the_identified_ratios():
    joint = Joint()
    with pytest.raises(FrozenInstanceError):
        joint.stiffness = 1.0
    assert joint.gravity_torque / joint.load_inertia == pytest.approx(33.3, rel=2e-3)
    assert joint.stiffness / joint.load_inertia == pytest.approx(5.2e4, rel=2e-3)
    assert joint.damping / joint.stiffness == pytest.approx(1.0e-3, rel=0.03)
    assert joint.load_inertia / (joint.gear_ratio**2 * joint.motor_inertia) == pytest.approx(8, rel=0.01)
    assert joint.speed_gain / joint.motor_inertia == pytest.approx(870, rel=0.01)


def test_speed_and_turn_derive_from_the_reference():
    assert Joint().nominal_speed == pytest.approx(100)
    assert Joint().turn == pytest.approx(0.4)
    slow = Joint(omega_ref=2 * pi * 50)
    assert slow.nominal_speed == pytest.approx(50)
    assert slow.turn == pytest.approx(0.8)


@pytest.mark.parametrize("name", [field.name for field in fields(Joint)])
def test_joint_refuses_bad_parameters(name):
    for value in (-1.0, float("nan"), float("inf"), "1", True, None):
        with pytest.raises(BenchError, match=name):
            Joint(**{name: value})


@pytest.mark.parametrize(
    "name", ["gear_ratio", "omega_ref", "motor_inertia", "load_inertia", "stiffness", "speed_gain"]
)
def test_joint_refuses_zero_where_the_model_divides_by_it(name):
    with pytest.raises(BenchError, match=name):
        Joint(**{name: 0.0})
