"""Rules of traits: which changes of a problem leave a run as it is, and which parameters change no point.

A trait is no error. A method may declare in ``invariances`` which of ``INVARIANCES`` it keeps, and then breaks the rule
where it does not; of others the finding is reported. Runs of one seed are compared point by point:

- translation, scale: the box and the function moved, or 64 times as small;
- monotone: the cube of the values, which leaves their order as it is;
- budget: the first half of a run with twice the budget, which a schedule that falls with the budget changes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import is_dataclass, replace
from typing import Any

import numpy as np

from bench.check.conformance.recording import ViolationError
from bench.check.conformance.subject import Subject, ordinary_budget
from bench.check.idle import alternatives
from bench.check.problems import RecordingProblem
from bench.contract.typing import Floats
from bench.helpers.errors import BenchError
from bench.helpers.text import joined

INVARIANCES = ("translation", "scale", "monotone", "budget")
TOLERANCE = 1e-6  # of the box: rounding grows from generation to generation


def check_invariances(subject: Subject) -> str:
    """A run keeps what the method declares; what else it keeps or loses is reported."""
    found = {name: _where(subject, name) for name in INVARIANCES}
    optimizer = subject.fresh()
    declared = getattr(optimizer, "invariances", ())
    for name in declared if isinstance(declared, Sequence) else [declared]:
        if name not in INVARIANCES:
            raise ViolationError(f"it declares the invariance {name!r}", f"declare some of {', '.join(INVARIANCES)}")
        if found[name]:
            raise ViolationError(
                f"it declares invariance to {name}, and its run changes ({found[name]})",
                "take lengths from the box and compare values by their order alone; or do not declare it",
            )
    kept, lost = ([name for name in found if bool(found[name]) is broken] for broken in (False, True))
    sentences = [f"the run is kept under {joined(kept)}"] if kept else []
    sentences += [f"it changes under {joined([f'{name} ({found[name]})' for name in lost])}"] if lost else []
    texts = getattr(type(optimizer), "__doc__", ""), getattr(type(optimizer).minimize, "__doc__", "")
    if found["budget"] and not any("budget" in (text or "") for text in texts):
        sentences.append("its documentation does not say that its course depends on the budget")
    return "; ".join(sentences)


def _where(subject: Subject, name: str) -> str:
    """Return from which evaluation on a change moves a point of the run, "" where it moves none."""
    budget = 2 * ordinary_budget(subject.fresh())
    plain, other = _problem(), _problem(name)
    first = plain.share(subject.run(plain, budget=budget).points)
    second = other.share(subject.run(other, budget=(2 if name == "budget" else 1) * budget).points)[: len(first)]
    if len(second) < len(first):
        return f"it ends after {len(second)} evaluations"
    moved = (np.abs(first - second) > TOLERANCE).any(axis=1)
    return f"from evaluation {int(moved.argmax()) + 1} on" if moved.any() else ""


def _problem(change: str = "") -> RecordingProblem:
    """Return a valley in an uneven box, moved, smaller or with other values; powers of two keep rounding small."""
    lower, upper = np.array([-4.0, 8.0, -1024.0]), np.array([4.0, 9.0, 1024.0])
    if change == "translation":
        moved = np.array([16.0, -32.0, 8192.0])
        lower, upper = lower + moved, upper + moved
    elif change == "scale":
        lower, upper = lower / 64, upper / 64

    def evaluate(x: Floats) -> Floats:
        u = (x - lower) / (upper - lower) - [0.3, 0.65, 0.8]
        values = 1 + (u**2 * [1.0, 10.0, 100.0]).sum(axis=1)
        return np.asarray(values**3 if change == "monotone" else values)

    return RecordingProblem(evaluate, lower, upper, name="valley")


def check_parameters_in_use(subject: Subject) -> str:
    """Every parameter changes some point of a run, or is reported as one that does not."""
    optimizer = subject.fresh()
    course = subject.run(instance=optimizer).course()
    idle = []
    tried: dict[str, list[object]] = alternatives(optimizer) if is_dataclass(optimizer) else {}
    for name, others in tried.items():
        if all(course == made for made in _courses(subject, optimizer, name, others)):
            idle.append(f"{name} (tried {', '.join(map(repr, others))})")
    return f"without effect on an ordinary run: {joined(idle)}" if idle else "every parameter that was tried has effect"


def _courses(subject: Subject, optimizer: Any, name: str, others: Sequence[object]) -> Iterator[list[int]]:
    for other in others:
        try:
            yield subject.run(instance=replace(optimizer, **{name: other})).course()
        except (BenchError, RuntimeError, ValueError):
            continue
