"""Traits of a method: what it declares is held, and what it keeps or loses is reported."""

from dataclasses import dataclass
from typing import ClassVar

import pytest

from bench.check.conformance.rules import find_rule, judge
from bench.check.conformance.subject import Subject
from tests.bench.check import faulty


@dataclass(frozen=True)
class Ranked(faulty.Walker):
    """Keeps the better of two points; a step is a share of the box."""

    invariances: ClassVar[tuple[str, ...]] = ("translation", "scale", "monotone", "budget")
    step: float = 0.1

    def move(self, x, f, objective, rng):
        best = x[f.argmin()]
        span = objective.upper - objective.lower
        return objective.repair(best + self.step * span * rng.standard_normal(x.shape))


@dataclass(frozen=True)
class Absolute(Ranked):
    """Its step is the same in every box."""

    def move(self, x, f, objective, rng):
        return objective.repair(x[f.argmin()] + self.step * rng.standard_normal(x.shape))


@dataclass(frozen=True)
class Origin(Ranked):
    """Walks towards the origin."""

    def move(self, x, f, objective, rng):
        return objective.repair(0.9 * super().move(x, f, objective, rng))


@dataclass(frozen=True)
class Weighing(Ranked):
    """Moves to the mean of its points, weighed by their values."""

    def move(self, x, f, objective, rng):
        span = objective.upper - objective.lower
        mean = (x / f[:, None]).sum(axis=0) / (1 / f).sum()
        return objective.repair(mean + self.step * span * rng.standard_normal(x.shape))


@dataclass(frozen=True)
class Cooling(Ranked):
    """Its step falls to the end of the run."""

    def move(self, x, f, objective, rng):
        span = objective.upper - objective.lower
        share = objective.remaining / objective.budget
        return objective.repair(x[f.argmin()] + self.step * share * span * rng.standard_normal(x.shape))


@dataclass(frozen=True)
class Undeclared(Cooling):
    invariances: ClassVar[tuple[str, ...]] = ()


@dataclass(frozen=True)
class Idle(Ranked):
    inertia: float = 0.7


def verdict(optimizer, rule="invariances"):
    return judge(find_rule(rule), Subject.of(optimizer, {}, 0))


def test_a_method_that_keeps_what_it_declares_passes():
    assert verdict(Ranked).finding == "the run is kept under translation, scale, monotone and budget"


@pytest.mark.parametrize(
    ("optimizer", "lost"),
    [(Absolute, "scale"), (Origin, "translation"), (Weighing, "monotone"), (Cooling, "budget")],
)
def test_a_declared_invariance_that_does_not_hold_is_a_breach(optimizer, lost):
    found = verdict(optimizer)
    assert found.outcome == "FAILED"
    assert f"invariance to {lost}, and its run changes (from evaluation" in found.finding
    assert "by their order alone" in found.remedy


def test_without_a_declaration_it_is_a_finding():
    found = verdict(Undeclared)
    assert found.passed
    assert "it changes under budget (from evaluation" in found.finding
    assert "its documentation does not say that its course depends on the budget" in found.finding


def test_a_parameter_that_changes_no_point_is_named_with_the_values_that_were_tried():
    assert verdict(Idle, "idle parameters").finding == (
        "without effect on an ordinary run: inertia (tried 1.4, 0.35, 1.7, -0.30000000000000004)"
    )
    assert verdict(Ranked, "idle parameters").finding == "every parameter that was tried has effect"
