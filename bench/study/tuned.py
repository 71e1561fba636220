"""The record of a tuning, as the table ``[tuning]`` of a study: what was tuned, on what, and at what cost.

Whether test problems were trained on cannot be seen in the trials; only the record shows it. So it holds a hash of its
content, and what was edited afterwards supports no claim. The hash protects from mistakes, and not from forgery.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from bench.errors import BenchError, nearest
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


def checked(value: Any, what: str) -> Tuning:
    """Return the record that a table holds; raises BenchError, naming the key, for what ``bench tune`` never writes."""
    if isinstance(value, Tuning):
        return value
    table = _typed(Tuning, {"sha256": ""} | value if isinstance(value, dict) else value, what)
    entries = table.pop("optimizers")
    tuned = tuple(Tuned(**_typed(Tuned, entry, f"{what}, optimizers")) for entry in entries)
    if not all(isinstance(name, str) for name in table["train"]):
        raise BenchError(f"{what}: 'train' must hold names of problems; restore what 'bench tune' wrote")
    for record in tuned:
        if not _is_readable(record):
            raise BenchError(f"{what}: the entry of {record.name!r} is damaged; restore what 'bench tune' wrote")
        lengths = {len(record.scores), len(record.problems), *map(len, record.values.values())}
        if len(lengths) > 1 or not record.scores:
            raise BenchError(
                f"{what}: the lists of {record.name!r} have different lengths; restore what 'bench tune' wrote"
            )
    return Tuning(**table | {"budget": Budget.read(table["budget"], f"{what}, 'budget'")}, optimizers=tuned)


def _is_readable(tuned: Tuned) -> bool:
    """Return whether a report can show the numbers and the parameters of a record."""
    numbers = [*tuned.scores, *tuned.problems, *tuned.importance.values(), tuned.seconds]
    axes = all(
        isinstance(axis, dict)
        and (isinstance(axis.get("choices"), list) or all(is_finite(axis.get(end)) for end in ("low", "high")))
        for axis in tuned.parameters.values()
    )
    lists = all(isinstance(tried, list) for tried in tuned.values.values())
    return all(map(is_finite, numbers)) and axes and lists and tuned.values.keys() == tuned.parameters.keys()


_KINDS: dict[str, type | tuple[type, ...]] = {
    "str": str, "int": int, "float": (int, float), "Budget": (int, str, dict), "list[str]": list, "list[int]": list,
    "list[float]": list, "dict[str, Any]": dict, "tuple[Tuned, ...]": (list, tuple),
}  # fmt: skip


def _typed(kind: type, value: Any, what: str) -> dict[str, Any]:
    """Return a table whose keys are the fields of a record, each of the kind of its field."""
    if not isinstance(value, dict):
        raise BenchError(f"{what} must be the table that 'bench tune' wrote, not {value!r}")
    fields = {item.name: str(item.type) for item in dataclasses.fields(kind)}
    for key in value:
        if key not in fields:
            raise BenchError(f"{what}: unknown key {key!r}{nearest(key, fields)}")
    for key, kind_of in fields.items():
        if not isinstance(value.get(key), _KINDS[kind_of]):
            raise BenchError(f"{what}: {key!r} is missing or of another kind; restore what 'bench tune' wrote")
    return dict(value)
