"""A cell: an optimizer on a problem, with all that decides the bits of its trials but their numbers."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import cache
from typing import Any, NamedTuple

from bench.plugins.code import differences as names_that_differ

Labels = tuple[str, str]
"""The labels of a problem and of an optimizer."""


class Cell(NamedTuple):
    """An optimizer on a problem, as a store keeps it; cells that are equal give equal trials.

    Attributes:
        problem: the record of the problem as JSON: ``label``, ``name``, ``options``, ``data`` (a hash, "" where the
            name determines it), the handlings ``constraints`` and ``on_error``, and the limits ``evaluation_timeout``
            and ``time`` where there are any.
        optimizer: the record of the optimizer: ``label``, ``name``, ``options`` and ``code``, by file its hash and by
            package its version (:mod:`bench.plugins.code`).
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


def record(**content: Any) -> str:
    """Return the record of a problem or an optimizer: equal content has equal texts."""
    return json.dumps(content, sort_keys=True, default=str)


@cache
def read(text: str) -> dict[str, Any]:
    """Return the content of a record, which must not be changed; of a damaged one nothing is known."""
    content = None
    with suppress(ValueError):
        content = json.loads(text)
    known = content if isinstance(content, dict) else {}
    return {"label": "unknown", "name": "", "options": {}} | known


def relabelled(text: str, label: str) -> str:
    """Return a record with this label."""
    return text if read(text)["label"] == label else record(**read(text) | {"label": label})


def alike(one: str, other: str) -> bool:
    """Return whether two records agree in all but their labels."""
    return relabelled(one, "") == relabelled(other, "")


def differences(before: str, now: str) -> Iterator[str]:
    """Yield in phrases how a record differs from the one before: the files that changed, or options."""
    old, new = read(before), read(now)
    for key in ("data", "code"):
        if old.get(key) != new.get(key):
            both = isinstance(old.get(key), Mapping) and isinstance(new.get(key), Mapping)
            yield ", ".join(names_that_differ(old[key], new[key])) if both else key
    if old["name"] != new["name"]:
        yield f"it is {new['name']!r}, not {old['name']!r}"
    for name in names_that_differ(old["options"], new["options"]):
        values = [
            repr(record["options"][name]) if name in record["options"] else "the default" for record in (new, old)
        ]
        yield f"{name} = {values[0]}, not {values[1]}"
    for key in ("constraints", "on_error", "evaluation_timeout", "time"):
        if old.get(key) != new.get(key):
            yield f"{key} = {new.get(key)!r}, not {old.get(key)!r}"
