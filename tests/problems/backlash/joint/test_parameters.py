"""A joint's parameters, and joints in TOML files."""

from dataclasses import fields, replace
from math import pi

import pytest

from bench.helpers.errors import BenchError
from problems.backlash.joint import Joint, half_gap, load_joint
from problems.backlash.joint.parameters import FIELDS, joint_text


def test_half_gaps_of_the_twenty_levels():
    assert half_gap(1) == 0.0001
    assert half_gap(2) == 0.0003
    assert half_gap(12) == 0.0023
    assert half_gap(20) == 0.0039


@pytest.mark.parametrize("part", fields(Joint), ids=lambda part: part.name)
def test_joint_refuses_bad_parameters(part):
    for name in vars(part.default):
        for value in (-1.0, float("nan"), float("inf"), "1", True, None):
            with pytest.raises(BenchError, match=name):
                Joint(**{part.name: replace(part.default, **{name: value})})


@pytest.fixture
def load(tmp_path):
    def load(text, **options):
        path = tmp_path / "joint.toml"
        path.write_text(text)
        return load_joint(path, **options)

    return load


def test_a_payload_is_a_point_mass_and_changes_the_load_alone(load):
    made = load("payload_kg = 10\nlever_m = 0.5")
    assert made == load_joint(gravity_torque=10 * 9.80665 * 0.5, load_inertia=2.5)


def test_speed_and_gravity_angle_set_the_reference_and_the_torque(load):
    assert load("speed_rps = 50") == load_joint(omega_ref=2 * pi * 50)
    assert load("gravity_angle_deg = 90") == Joint()
    assert load("gravity_angle_deg = 0") == load_joint(gravity_torque=0.0)
    half = load("payload_kg = 5\ngravity_angle_deg = 30")
    assert half.load.gravity_torque == pytest.approx(load("payload_kg = 5").load.gravity_torque / 2)


def test_a_joint_s_text_is_that_joint_and_explains_every_parameter(load):
    joint = load_joint(gear_ratio=121.0, coulomb_friction=0.1, omega_ref=1 / 3)
    text = joint_text(joint)
    assert load(text) == joint
    for name, field in FIELDS.items():
        (line,) = (line for line in text.splitlines() if line.startswith(f"{name} ="))
        assert line.endswith(f"# {field.metadata['meaning']}")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("gear_rato = 40", "no parameter 'gear_rato'; did you mean 'gear_ratio'?"),
        ('gear_ratio = "40"', "gear_ratio must be a finite number, not '40'"),
        (f"gear_ratio = 1{'0' * 400}", "gear_ratio must be a finite number"),
        ("stiffness = -1", "stiffness must be finite and positive, but it is -1.0"),
        ("payload_kg = 0", "payload_kg must be a positive number, not 0"),
        ("gravity_angle_deg = 91", "gravity_angle_deg must be from 0 (parallel to gravity) to 90, but it is 91"),
        ("payload_kg = 5\ngravity_torque = 3", "gives both gravity_torque and payload_kg"),
        ("gear_ratio 40", "is not valid TOML"),
    ],
)
def test_a_wrong_file_is_one_sentence_that_names_it(load, tmp_path, text, message):
    with pytest.raises(BenchError) as caught:
        load(text)
    assert message in str(caught.value)
    assert str(caught.value).startswith(f"joint {tmp_path / 'joint.toml'}")
    assert "\n" not in str(caught.value)
