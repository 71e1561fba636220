"""The simulated robot joint of thesis chapter 4: the source of the home problem's signals."""

from problems.backlash.joint.parameters import DEFAULT, Drive, Gear, Joint, Load, half_gap, load_joint
from problems.backlash.joint.simulator import Simulation, simulate, with_noise

__all__ = [
    "DEFAULT",
    "Drive",
    "Gear",
    "Joint",
    "Load",
    "Simulation",
    "half_gap",
    "load_joint",
    "simulate",
    "with_noise",
]
