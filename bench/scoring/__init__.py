"""What is recorded where an optimizer sees something else: constraints, noise and integer variables."""

from bench.scoring.problem import Scored, objective, scored

__all__ = ["Scored", "objective", "scored"]
