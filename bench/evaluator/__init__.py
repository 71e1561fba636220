"""Judge optimizers that a program writes: their score on training problems, and once a comparison on held-out ones."""

from bench.evaluator.evaluator import Evaluator
from bench.evaluator.found import Final, Found

__all__ = ["Evaluator", "Final", "Found"]
