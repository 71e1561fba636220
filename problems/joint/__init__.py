"""The simulated robot joint of thesis chapter 4: where the home problem's signals come from."""

from problems.joint.parameters import Joint, half_gap
from problems.joint.simulator import Simulation, simulate

__all__ = ["Joint", "Simulation", "half_gap", "simulate"]
