"""Matched controls: the optimizers of a study under each other's conditions, so that only the algorithms differ."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace

from bench.helpers.text import free
from bench.optimizer import CONDITIONS
from bench.study.descriptions import Description, Values, value_of
from bench.study.entries import Entry
from bench.study.study import Study


@dataclass(frozen=True)
class Matched:
    """Conditions that some optimizer of a study has, and each algorithm of the study under them.

    Attributes:
        values: the conditions that are not those of all; a population that its optimizer chooses is none of them.
        entries: by the label of each algorithm (:func:`algorithms`), its entry under these conditions, as far as it
            has such options: an optimizer or a control of the study, or the control that it lacks.
        apart: by the same label, the conditions of ``values`` that the algorithm has no option for.
    """

    values: Values
    entries: dict[str, Entry]
    apart: dict[str, list[str]]


def with_controls(study: Study, descriptions: Mapping[str, Description]) -> Study:
    """Return the study with each of its optimizers under the conditions of the others, as controls."""
    conditions = matched(study, descriptions)
    wanted = {entry.label: entry for condition in conditions for entry in condition.entries.values()}
    present = {entry.label for entry in study.with_controls}
    missing = (entry for label, entry in wanted.items() if label not in present)
    return replace(study, controls=(*study.controls, *missing))


def algorithms(study: Study) -> dict[str, str]:
    """Return for each optimizer the label of the first one that differs from it in conditions alone, or its own."""
    firsts: dict[str, str] = {}
    return {entry.label: firsts.setdefault(_algorithm(entry), entry.label) for entry in study.optimizers}


def matched(study: Study, descriptions: Mapping[str, Description]) -> list[Matched]:
    """Return the conditions that a study's optimizers have, each with all algorithms; none where nothing differs.

    Args:
        study: with the controls that it has already.
        descriptions: of its optimizers and controls (:class:`bench.study.descriptions.Description`); those whose
            parameters are not known take no part.
    """
    present = {label: about.conditions for label, about in descriptions.items() if about.values is not None}
    compared = [entry for entry in study.optimizers if entry.label in present]
    wanted = [dict(pairs) for pairs in dict.fromkeys(tuple(descriptions[entry.label].shareable) for entry in compared)]
    differing = [name for name in CONDITIONS if len({values.get(name) for values in wanted}) > 1]
    if not differing:
        return []
    kinds = algorithms(study)
    firsts = [entry for entry in compared if kinds[entry.label] == entry.label]
    placed = {
        (_algorithm(entry), *present[entry.label].items()): entry for entry in reversed(study.with_controls)
        if entry.label in present
    }  # fmt: skip
    unique: dict[tuple[str, ...], Matched] = {}
    for values in wanted:
        entries, apart = {}, {}
        for first in firsts:
            before, accepts = present[first.label], descriptions[first.label].accepts
            changes = {
                name: value
                for name, value in values.items()
                if before.get(name) != value and value in accepts.get(name, ())
            }
            place = (_algorithm(first), *(before | changes).items())
            if place not in placed:
                taken = {entry.label for entry in (*study.with_controls, *placed.values())}
                placed[place] = _control(first, changes, taken)
            entries[first.label] = placed[place]
            apart[first.label] = [n for n in differing if n in values and (before | changes).get(n) != values[n]]
        shown = {name: value for name, value in values.items() if name in differing}
        if shown:
            unique.setdefault(tuple(entry.label for entry in entries.values()), Matched(shown, entries, apart))
    return list(unique.values())


def _algorithm(entry: Entry) -> str:
    """Return a text that is equal for two optimizers that differ in conditions alone."""
    return json.dumps([entry.name, {k: v for k, v in entry.options.items() if k not in CONDITIONS}], default=str)


def _control(first: Entry, changes: Values, taken: set[str]) -> Entry:
    """Return an optimizer under other conditions; the label names these."""
    named = ", ".join(f"{value} agents" if name == "agents" else value for name, value in changes.items())
    options = first.options | {name: value_of(value) for name, value in changes.items()}
    return Entry(first.name, free(f"{first.label} ({named})", taken), options)
