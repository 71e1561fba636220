"""Checks of an optimizer, its contract and the biases of its method, and of a problem."""

from bench.check.checker import check_optimizer, check_problem
from bench.check.verdict import Checkup, Verdict

__all__ = ["Checkup", "Verdict", "check_optimizer", "check_problem"]
