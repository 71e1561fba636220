"""The simulated robot joint of thesis chapter 4: where the home problem's signals come from."""

from problems.joint.files import load_joint
from problems.joint.parameters import Joint, half_gap
from problems.joint.simulator import Simulation, simulate, with_noise

__all__ = ["Joint", "Simulation", "half_gap", "load_joint", "simulate", "with_noise"]
