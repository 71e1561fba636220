"""Checks of an optimizer: whether it keeps the contract, and what biases its method has."""

from bench.check.suite import Checkup, check_optimizer
from bench.check.verdict import Verdict

__all__ = ["Checkup", "Verdict", "check_optimizer"]
