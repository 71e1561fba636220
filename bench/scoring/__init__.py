"""What is recorded where an optimizer sees something else: constraints, noise, integer variables and failures."""

from bench.scoring.problem import Scored, objective, require_on_error, scored

__all__ = ["Scored", "objective", "require_on_error", "scored"]
