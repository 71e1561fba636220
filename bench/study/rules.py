"""The rules of a study's trials: how their points are evaluated, and what ends a trial before its budget."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import inf, nextafter

from bench.contract.numbers import MOST_PARALLEL, is_finite, require_flag, require_positive, require_whole, seconds
from bench.contract.problem import Problem
from bench.helpers.errors import BenchError
from bench.helpers.parsing import JsonObject
from bench.study.values import Checked
from bench.trial.scoring import constraints as handlings
from bench.trial.scoring import require_on_error


def _finite(value: object, what: str) -> float:
    if not is_finite(value):
        raise BenchError(f"{what} must be a number, not {value!r}")
    return float(value)


@dataclass(frozen=True)
class Rules:
    """The rules of a study's trials; its file has each of them as a key.

    Attributes:
        constraints: what optimizers see of infeasible points, one of :data:`bench.trial.scoring.constraints.HANDLINGS`.
        on_error: what becomes of a point at which a problem raises: "fail", the trial fails and reports do not compare
            the problem; "worst", the point counts, its value is +inf and the trial goes on.
        evaluation_timeout: wall seconds that the evaluation of a point may take, or a text such as ``"10 min"``; it is
            made in a process that is ended then, and the point fails. None: no limit.
        time: wall seconds after which a trial ends before its budget, or a text such as ``"10 min"``: the call of the
            objective that is then under way is its last. Such a trial cannot be repeated bit by bit. None: no limit.
        final_target: the difference to the known optimum at which a trial ends, such as 1e-8 in COCO (Hansen et al.
            2021); None: none.
        stop_at: the value at which a trial ends once a feasible point has it; None: none.
        parallel: points of a call that are evaluated at a time, each in a process of the problem; it decides no
            trial's result.
        journal: whether the evaluations of a trial are noted in the folder whatever they take, for a trial that was
            interrupted; otherwise slow ones are. It decides no trial's result.

    Raises:
        BenchError: for a value that cannot be.
    """

    constraints: Checked[str] = Checked(handlings.read_handling, handlings.DEFAULT)
    on_error: Checked[str] = Checked(require_on_error, "fail")
    evaluation_timeout: Checked[float | None] = Checked(seconds)
    time: Checked[float | None] = Checked(seconds)
    final_target: Checked[float | None] = Checked(lambda value, what: require_positive(what, value))
    stop_at: Checked[float | None] = Checked(_finite)
    parallel: Checked[int] = Checked(lambda value, what: require_whole(what, value, 1, MOST_PARALLEL), 1)
    journal: Checked[bool] = Checked(lambda value, what: require_flag(what, value), False)

    @property
    def evaluation(self) -> tuple[int, float | None]:
        """The points of a call that are evaluated at a time, and the wall seconds that each may take."""
        return self.parallel, self.evaluation_timeout

    @property
    def unusual(self) -> JsonObject:
        """The rules by key, but those that are the default ones."""
        values = {each: getattr(self, each.name) for each in fields(self)}
        return {each.name: value for each, value in values.items() if value != each.default}

    @property
    def deciding(self) -> JsonObject:
        """The unusual rules that decide a trial's result."""
        return {key: value for key, value in self.unusual.items() if key not in ("parallel", "journal")}

    def goal(self, problem: Problem) -> float:
        """Return the value that ends a trial on the problem once a feasible point has it; -inf where none does.

        Raises:
            BenchError: for a difference to an optimum that is not known.
        """
        value = -inf if self.stop_at is None else self.stop_at
        if self.final_target is None:
            return value
        if problem.optimum is None:
            raise BenchError(
                f"problem {problem.name!r} has no known optimum, from which 'final_target' counts; give 'stop_at', a "
                "value"
            )
        near = problem.optimum + self.final_target
        while near - problem.optimum > self.final_target:  # the sum is rounded, and reports subtract
            near = nextafter(near, -inf)
        return max(near, value)


def read_rules(value: object, what: str) -> Rules:
    """Return rules as they are; raises BenchError for anything else."""
    if not isinstance(value, Rules):
        raise BenchError(f"{what} must be a bench.study.rules.Rules, not {value!r:.100}")
    return value


KEYS = {each.name for each in fields(Rules)}
"""The keys of a study's file that are rules."""
