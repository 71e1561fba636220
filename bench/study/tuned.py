"""The record of a tuning, the table ``[tuning]`` of a study: parameters, training problems and cost.

Whether test problems were trained on cannot be seen in the trials; only the record shows it. So it holds a hash of its
content, and what was edited afterwards supports no claim. The hash protects from mistakes, and not from forgery.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from bench.errors import BenchError
from bench.numbers import is_finite
from bench.study.budget import Budget

AUTOMATIC = "null"
"""The text of a value that the optimizer chooses by itself, as :func:`bench.helpers.text.option` writes None."""


@dataclass(frozen=True)
class Tuned:
    """The tuning of one optimizer.

    Attributes:
        name: the optimizer's plug-in name.
        default: the label of its defaults in the study.
        tuned: the label of the best configuration; that of the defaults where none was better.
        parameters: what was tried: ``low``, ``high`` and ``log``, or ``choices``, by parameter.
        values: the value of each configuration in the order of trying, by parameter; the first are the defaults.
        scores: the score of each configuration over the training problems it ran on; lower is better.
        problems: on how many training problems each configuration ran; fewer than all where it was stopped.
        failed: runs that failed, of all configurations.
        evaluations: evaluations spent, of all configurations.
        seconds: wall seconds of their runs, added up.
        importance: the share of each parameter in the variance of the scores (PED-ANOVA), where it is known.
    """

    name: str
    default: str
    tuned: str
    parameters: dict[str, Any]
    values: dict[str, Any]
    scores: list[float]
    problems: list[int]
    failed: int
    evaluations: int
    seconds: float
    importance: dict[str, Any] = field(default_factory=dict)

    @property
    def whole(self) -> list[bool]:
        """Whether each configuration ran on all training problems, as the defaults always do."""
        return [number == self.problems[0] for number in self.problems]

    @property
    def best(self) -> float:
        """The lowest score of a configuration that ran on all training problems."""
        return min(score for score, whole in zip(self.scores, self.whole, strict=True) if whole)


@dataclass(frozen=True)
class Tuning:
    """The tuning of the optimizers of a study.

    Attributes:
        objective: what was minimised over the training problems: "aocc" (one less the area) or "regret".
        trials: the configurations that each optimizer could try.
        runs: the runs of a configuration on a training problem.
        budget: the evaluations of a run.
        seed: the seed of the tuning.
        train: the names of the training problems.
        left_out: the group of functions whose problems are the test problems; "" without one.
        method: the sampler and the pruner, with the version of their library.
        optimizers: the tuning of each optimizer.
        sha256: the hash of all of this as ``bench tune`` wrote it; "" in records of versions that wrote none.
    """

    objective: str
    trials: int
    runs: int
    budget: Budget
    seed: int
    train: list[str]
    left_out: str
    method: str
    optimizers: tuple[Tuned, ...]
    sha256: str = ""

    @classmethod
    def read(cls, value: Any, what: str) -> Tuning:
        """Return the record that a table holds; ``what`` is the subject of a sentence about it.

        Raises:
            BenchError: for what ``bench tune`` never writes.
        """
        if isinstance(value, Tuning):
            return value
        whole = False
        with suppress(AttributeError, KeyError, TypeError, ValueError):
            optimizers = tuple(Tuned(**entry) for entry in value["optimizers"])
            record = cls(**value | {"budget": Budget.read(value["budget"]), "optimizers": optimizers})
            whole = _is_whole(record)
        if not whole:
            raise BenchError(f"{what} must be a table as 'bench tune' writes it; restore it, or leave it out")
        return record

    def sealed(self) -> Tuning:
        """Return the record with the hash of its content."""
        return dataclasses.replace(self, sha256=self._hash())

    def _hash(self) -> str:
        """Return the SHA-256 of the content but the hash itself, as JSON with sorted keys."""
        content = {key: value for key, value in self.as_dict().items() if key != "sha256"}
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()

    @property
    def doubt(self) -> str:
        """A sentence on why the record supports no claim; "" where its content fits its hash."""
        if self.sha256 == self._hash():
            return ""
        why = "does not fit its hash: it was edited" if self.sha256 else "has no hash: an earlier version wrote it"
        return (
            f"The record of the tuning {why}, so it does not show on which problems the optimizers were tuned; repeat "
            "'bench tune', or restore what it wrote."
        )

    def is_apart(self, problems: Iterable[str]) -> bool:
        """Return whether the record shows that none of the problems of these names was trained on."""
        return not self.doubt and not set(self.train) & set(problems)

    def as_dict(self) -> dict[str, Any]:
        """Return the record as a table of a study file."""
        return dataclasses.asdict(self) | {
            "budget": self.budget.plain, "optimizers": [dataclasses.asdict(tuned) for tuned in self.optimizers]
        }  # fmt: skip

    def require_apart(self, problems: Iterable[str], where: str) -> None:
        """Raise BenchError where a problem of these names was trained on."""
        both = sorted(set(self.train) & set(problems))
        if both:
            more = f" and {len(both) - 1} more" if len(both) > 1 else ""
            raise BenchError(
                f"{where}: the optimizers were tuned on {both[0]!r}{more}, so it cannot be a test problem; leave it out"
            )


def _is_whole(tuning: Tuning) -> bool:
    """Return whether a report can show each value of a record."""
    texts = [tuning.objective, tuning.left_out, tuning.method, tuning.sha256, *tuning.train]
    numbers: list[float] = [tuning.trials, tuning.runs, tuning.seed]
    fit = isinstance(tuning.train, list)
    for tuned in tuning.optimizers:
        texts += [tuned.name, tuned.default, tuned.tuned]
        numbers += [*tuned.scores, *tuned.problems, *tuned.importance.values()]
        numbers += [tuned.failed, tuned.evaluations, tuned.seconds]
        fit &= len({len(tuned.scores), len(tuned.problems), *map(len, tuned.values.values())}) == 1 <= len(tuned.scores)
        fit &= tuned.values.keys() == tuned.parameters.keys()
        for axis in tuned.parameters.values():
            fit &= isinstance(axis.get("choices"), list) or (is_finite(axis.get("low")) and is_finite(axis.get("high")))
    return fit and all(isinstance(text, str) for text in texts) and all(map(is_finite, numbers))
