"""Record true values where an optimizer sees others: constraints, noise, integer variables and failures."""

from bench.trial.scoring.goal import goal, read_final_target, read_stop_at
from bench.trial.scoring.problem import Scored, objective, require_on_error, scored

__all__ = ["Scored", "goal", "objective", "read_final_target", "read_stop_at", "require_on_error", "scored"]
