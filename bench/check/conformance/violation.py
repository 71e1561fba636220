"""Violations of a rule: what was observed, and how to mend it."""

from __future__ import annotations

from itertools import zip_longest

from bench.execution.trial_process import STILL_ASKING
from bench.sandbox.process import DiedError, Process, SilentError

LET_IT_PASS = "let BudgetExhausted pass: catch Exception, never BaseException or everything (a bare except)"


class ViolationError(Exception):
    """The optimizer breaks the rule: what was observed, and how to mend it."""

    def __init__(self, finding: str, mend: str) -> None:
        super().__init__(finding)
        self.finding, self.mend = finding, mend


def expect_same(one: list[int], other: list[int], finding: str, mend: str) -> None:
    """Raise ViolationError, naming the first evaluation that differs, unless both courses of runs are equal."""
    if one != other:
        first = next(i for i, (a, b) in enumerate(zip_longest(one, other), 1) if a != b)
        raise ViolationError(f"{finding} (from evaluation {first} on)", mend)


def explain_lost_process(error: SilentError | DiedError, process: Process) -> tuple[str, str]:
    """Return the finding on an optimizer that hung or ended its process, and how to mend it."""
    made, budget = process.pulse or (0, 0)
    if isinstance(error, DiedError) and error.code == STILL_ASKING:
        return f"it calls the objective for ever after its budget of {budget} is spent", LET_IT_PASS
    if isinstance(error, DiedError):
        return f"it ended the process that it ran in ({error})", (
            "raise an exception where it cannot go on; a signal means a crash in compiled code"
        )
    if budget and made == budget:
        return f"it did not end within {error} after its budget of {budget} was spent", (
            f"{LET_IT_PASS}; or look for a loop that does not call the objective"
        )
    return f"it asked for no value for {error}, after {made} evaluations", (
        "look for a loop that never calls the objective, or for a lock that is never released"
    )
