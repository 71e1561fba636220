"""How many defects, planted in sound methods, ``bench check`` finds, and how often it raises a false alarm.

    python validation/defects.py [rules | biases] [METHOD ...]        # default: rules, all methods

Each method runs behind an objective that plants one defect. A defect counts as found where the check of its kind fails
or finds what it did not find of the method alone; a false alarm is any failed rule of the method alone.
"""

import sys
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np

from bench import Optimizer, load_optimizer
from bench.check.bias import diagnose
from bench.check.checker import Checker
from bench.check.conformance.rules import RULES
from bench.check.conformance.subject import Subject
from bench.check.verdict import Verdict

METHODS = (
    "random-search", "cma-es-fast", "bipop-cma-es", "gwo", "alo", "goa", "da", "minion:LSHADE", "minion:PSO",
    "scipy:differential_evolution",
)  # fmt: skip
RULE_OF = {
    "an absolute grid of points": ("invariances",),
    "the global random state": ("global states",),
    "memory of the last run": ("repetition", "processes"),
    "a parameter without effect": ("idle parameters",),
    "an early end": ("budget",),
    "points outside the box": ("box",),
}
"""The planted defects that rules shall find, and the rules that shall find each."""

BIAS_OF = {"a pull to the centre": "centre bias", "points near a bound put onto it": "boundary clamping"}


class EndedError(BaseException):
    """The planted end of a run, which no method catches."""


@dataclass(frozen=True)
class Planted(Optimizer):
    """A method with a defect."""

    method: str = "random-search"
    defect: str = ""

    @property
    def minimum_budget(self) -> int:
        """The budget of the method's own generation."""
        return load_optimizer(self.method).minimum_budget

    def minimize(self, objective: Any, rng: np.random.Generator) -> None:
        """Run the method on an objective that plants the defect."""
        with suppress(EndedError):
            load_optimizer(self.method).minimize(Changed(objective, self.defect), rng)


@dataclass(frozen=True)
class WithIdle(Planted):
    """The same with a parameter that is read and never used."""

    inertia: float = 0.5


class Changed:
    """An objective that evaluates other points than it is asked for, or ends too early."""

    def __init__(self, objective: Any, defect: str) -> None:
        self.objective, self.defect = objective, defect

    def __getattr__(self, name: str) -> Any:
        return getattr(self.objective, name)

    def __call__(self, x: Any) -> Any:
        """Return the values of other points than the (n, d) or (d,) ``x``, depending on the defect."""
        low, high = self.objective.lower, self.objective.upper
        points = np.array(x, dtype=float)
        if self.defect == "a pull to the centre":
            drawn = np.abs(points * 1e6 % 1).sum(axis=-1, keepdims=True) % 1 < 0.1  # a tenth of them
            points = np.where(drawn, (low + high) / 2 + 1e-3 * (points - (low + high) / 2), points)
        elif self.defect == "points near a bound put onto it":
            points = np.where(points < low + 0.05 * (high - low), low, points)
            points = np.where(points > high - 0.05 * (high - low), high, points)
        elif self.defect == "an absolute grid of points":
            points = np.clip(np.round(points, 2), low, high)
        elif self.defect == "the global random state":
            points = np.clip(points + 1e-6 * (high - low) * np.random.rand(), low, high)  # noqa: NPY002
        elif self.defect == "memory of the last run":
            last = vars(sys).setdefault("planted", {})  # of the process, as a module of the method has it
            points = np.clip(points + 1e-3 * (high - low) * last.get(len(low), 0.0), low, high)
            last[len(low)] = (points.reshape(-1, len(low))[0] - low) / (high - low)
        elif self.defect == "points outside the box":
            points = points + 0.02 * (high - low)
        elif self.defect == "an early end" and self.objective.remaining < 0.2 * self.objective.budget:
            raise EndedError
        return self.objective(points)


def verdicts(method: str, defect: str, rules: Any) -> dict[str, Verdict]:
    """Return the verdicts on a method with a defect by rule, in a process of its own."""
    kind = WithIdle if defect == "a parameter without effect" else Planted
    checker = Checker(Subject.of(kind(method, defect), {}, 0))
    found = {verdict.check: verdict for verdict in filter(None, map(checker.verdict, rules))}
    checker.close()
    return found


def rate(found: list[bool]) -> str:
    """Return a share with its standard error, by Agresti and Coull's estimate."""
    share, n = (sum(found) + 2) / (len(found) + 4), len(found) + 4
    return f"{sum(found):3} of {len(found):3}, {sum(found) / len(found):4.0%} ± {sqrt(share * (1 - share) / n):.0%}"


def main() -> None:
    what, methods = (sys.argv[1] if len(sys.argv) > 1 else "rules"), sys.argv[2:] or METHODS
    for line in by_rules(methods) if what == "rules" else by_biases(methods):
        print(line, flush=True)


def by_rules(methods: Any) -> Iterator[str]:
    plain = {method: verdicts(method, "", RULES) for method in methods}
    for method, found in plain.items():
        alarms = [f"{name}: {verdict.finding}" for name, verdict in found.items() if not verdict.passed]
        yield f"{method}: {'; '.join(alarms) or 'no rule is broken'}; {found['invariances'].finding}"
    for defect, names in RULE_OF.items():
        marks = {}
        for method in methods:
            found = verdicts(method, defect, [rule for rule in RULES if rule.name in names])
            marks[method] = any(
                not verdict.passed or (name in plain[method] and news(verdict, plain[method][name]))
                for name, verdict in found.items()
            )
        missed = [method for method, is_found in marks.items() if not is_found]
        yield f"{defect:28} {' or '.join(names):24} {rate(list(marks.values()))}  missed: {', '.join(missed) or 'none'}"


def news(verdict: Verdict, before: Verdict) -> bool:
    """Return whether a finding names something broken or idle that the one before does not."""
    words = ("translation (", "scale (", "monotone (", "inertia (")
    return any(word in verdict.finding and word not in before.finding for word in words)


def by_biases(methods: Any) -> Iterator[str]:
    marks: dict[str, list[bool]] = {}
    for method in methods:
        plain = {each.check: each.passed for each in diagnose(Planted(method, ""), n_jobs=2)}
        broken = [name for name, passed in plain.items() if not passed]
        yield f"{method} alone: biased in {', '.join(broken) or 'nothing'}"
        for defect, check in BIAS_OF.items():
            found = {each.check: each for each in diagnose(Planted(method, defect), n_jobs=2)}
            marks.setdefault(defect, []).append(not found[check].passed)
            yield f"{method}, {defect}: {found[check].outcome}, {found[check].finding}"
    for defect, found_ones in marks.items():
        yield f"{defect:32} {BIAS_OF[defect]:16} {rate(found_ones)}"


if __name__ == "__main__":
    main()
