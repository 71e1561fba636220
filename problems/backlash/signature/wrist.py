"""Simulate the wrist of thesis section 8.3: joints 4, 5 and 6 of a robot before and after tampering, and joint 1.

The thesis prints neither gear ratios, speeds and noise of the robot's joints nor their gaps; its flange bore the
maximum payload, 170 kg. Here they are choices: loads of 5 to 8 kg and ratios near the bench's, half a load turn a
second, and the gaps whose disturbance has the amplitude that the thesis expected.
Joint 1, whose axis is vertical, has a gap like joint 6's and friction of 2% of the bench's gravity torque.
"""

from math import pi
from typing import NamedTuple

import numpy as np

from bench.contract.numbers import require_whole
from problems.backlash.joint import Joint, load_joint, simulate, with_noise
from problems.backlash.recordings import Recording
from problems.backlash.signature.datasets import RATE

SWEEP, RAMP = 1.4 * pi, 0.3  # rad and s, of each movement
BEFORE, LENGTH = 0.6, 0.8  # s from rest to the recording, and of the recording: at full speed, gravity's zero within
STATES = ("healthy", "tampered")


class WristJoint(NamedTuple):
    """A joint of the robot: its half-gaps healthy and tampered, rad, and the noise, rps peak to peak."""

    joint: Joint
    half_gaps: tuple[float, float]
    noise: float


AXES = {
    1: WristJoint(load_joint(speed_rps=20.0, gravity_angle_deg=0.0, coulomb_friction=0.3), (0.000128, 0.002074), 0.1),
    4: WristJoint(load_joint(gear_ratio=80.0, speed_rps=40.0, payload_kg=8.0, lever_m=0.3), (0.000089, 0.000308), 0.1),
    5: WristJoint(load_joint(gear_ratio=60.0, speed_rps=30.0, payload_kg=8.0, lever_m=0.25), (0.000049, 0.00012), 0.1),
    6: WristJoint(load_joint(speed_rps=20.0), (0.000128, 0.002074), 0.1),
}


def parts(name: str) -> tuple[int, str]:
    """Return the number of the joint and its state from a problem's name, such as "wrist-4-healthy"."""
    _, number, state = name.split("-")
    return int(number), state


def recorded(name: str, draw: int = 0) -> Recording:
    """Return the recording of a joint at full speed, once through gravity's lowest point, with a draw of its noise.

    Raises:
        BenchError: for a draw that is not a whole number of at least 0.
    """
    require_whole("draw", draw, 0)
    number, state = parts(name)
    axis = AXES[number]
    made = simulate(
        axis.joint, half_gap=axis.half_gaps[STATES.index(state)], sweep=SWEEP, ramp=RAMP, settle=BEFORE,
        start_angle=-pi / 4, duration=LENGTH, rate=RATE,
    )  # fmt: skip
    rng = np.random.default_rng([number, STATES.index(state), draw])
    return Recording(0.0, 1 / RATE, with_noise(made.speed, axis.noise, rng), peak=made.peak)
