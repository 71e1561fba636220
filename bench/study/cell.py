"""A cell: an optimizer on a problem, with all that decides the bits of its trials but their numbers."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from typing import NamedTuple

from bench.helpers.parsing import JsonObject

Labels = tuple[str, str]
"""The labels of a problem and of an optimizer."""


class Cell(NamedTuple):
    """An optimizer on a problem, as a store keeps it; cells that are equal give equal trials.

    Attributes:
        problem: the record of the problem as JSON: ``label``, ``name``, ``options``, the handlings ``constraints`` and
            ``on_error``, what ends evaluations and trials (``evaluation_timeout``, ``time``, ``final_target``,
            ``stop_at``) where there is any, and ``inputs``, a number: a store counts the sets of inputs
            (:mod:`bench.plugins.inputs`) that it has trials of, from 1.
        optimizer: the record of the optimizer: ``label``, ``name``, ``options`` and ``inputs``.
        evaluations: what a trial may spend; 0 where that is not known of imported results.
        seed: the study's, from which with both labels all seeds derive.
    """

    problem: str
    optimizer: str
    evaluations: int
    seed: int

    @property
    def records(self) -> tuple[str, str]:
        """The records of problem and optimizer."""
        return self.problem, self.optimizer

    @property
    def conditions(self) -> tuple[int, int]:
        """The evaluations and the seed."""
        return self.evaluations, self.seed

    @property
    def labels(self) -> Labels:
        """The labels from which seeds are made; a study may show others (:mod:`bench.storage.selection`)."""
        return read(self.problem)["label"], read(self.optimizer)["label"]

    @property
    def bare(self) -> Cell:
        """The cell whatever its inputs: with the number 1 for each."""
        return Cell(with_inputs(self.problem, 1), with_inputs(self.optimizer, 1), *self.conditions)


def record(**content: object) -> str:
    """Return the record of a problem or an optimizer: equal content has equal texts."""
    return json.dumps({"inputs": 1} | content, sort_keys=True, default=str)


@cache
def read(text: str) -> JsonObject:
    """Return the content of a record, which must not be changed; of a damaged one nothing is known."""
    content = None
    with suppress(ValueError):
        content = json.loads(text)
    known = content if isinstance(content, dict) else {}
    return {"label": "unknown", "name": "", "options": {}, "inputs": 1} | known


def relabelled(text: str, label: str) -> str:
    """Return a record with this label."""
    return text if read(text)["label"] == label else record(**read(text) | {"label": label})


def with_inputs(text: str, number: int) -> str:
    """Return a record with this number of its inputs."""
    return text if read(text)["inputs"] == number else record(**read(text) | {"inputs": number})


def alike(one: str, other: str) -> bool:
    """Return whether two records agree in all but their labels and inputs."""
    return relabelled(with_inputs(one, 1), "") == relabelled(with_inputs(other, 1), "")


def differences(before: str, now: str) -> Iterator[str]:
    """Yield in phrases how the options of a record differ from those of the one before."""
    old, new = read(before), read(now)
    if old["name"] != new["name"]:
        yield f"it is {new['name']!r}, not {old['name']!r}"
    for name in names_that_differ(old["options"], new["options"]):
        values = [
            repr(record["options"][name]) if name in record["options"] else "the default" for record in (new, old)
        ]
        yield f"{name} = {values[0]}, not {values[1]}"
    for key in ("constraints", "on_error", "evaluation_timeout", "time", "final_target", "stop_at"):
        if old.get(key) != new.get(key):
            yield f"{key} = {new.get(key)!r}, not {old.get(key)!r}"


def names_that_differ(before: JsonObject, now: JsonObject) -> list[str]:
    """Return the names that are new, gone or changed."""
    return [name for name in {**before, **now} if before.get(name) != now.get(name)]
