"""Checks of an optimizer: whether it keeps the contract, and what biases its method has."""

from bench.check.checker import check_optimizer
from bench.check.verdict import Checkup, Verdict

__all__ = ["Checkup", "Verdict", "check_optimizer"]
