"""Record true values where an optimizer sees others: constraints, noise, integer variables and failures."""

from bench.trial.scoring.problem import Scored, objective, require_on_error, scored

__all__ = ["Scored", "objective", "require_on_error", "scored"]
