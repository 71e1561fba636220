"""Descriptions of a study's optimizers: BibTeX, parameters, and the conditions of other optimizers that they accept.

A run reads them where it checks the study, in processes that can be lost, and notes them in its folder, so that a
report starts no process and loads no stranger's code.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

from bench.helpers.parsing import parse_json
from bench.helpers.text import option, printable
from bench.optimizer import CONDITIONS, defaults, settings
from bench.plugins import loading
from bench.study.entries import Entry
from bench.study.study import Study
from bench.study.tuned import AUTOMATIC

LONGEST = 200  # characters of a value

Values = dict[str, str]  # of parameters, as texts by name


@dataclass(frozen=True)
class Description:
    """An optimizer as its plug-in describes it where it was run.

    Attributes:
        bibtex: the works that introduced it; "" where the plug-in is missing there or gives no text.
        values: its parameters as texts, by name; None where it cannot be loaded, so that they are not known.
        defaults: likewise, without a parameter that has no default.
        accepts: the values of :data:`bench.optimizer.CONDITIONS` that other optimizers of the study have and that it
            accepts, by condition.
    """

    bibtex: str = ""
    values: Values | None = None
    defaults: Values | None = None
    accepts: dict[str, list[str]] = field(default_factory=dict)

    @property
    def conditions(self) -> Values:
        """The conditions that it has."""
        values = self.values or {}
        return {name: values[name] for name in CONDITIONS if name in values}

    @property
    def shareable(self) -> Iterator[tuple[str, str]]:
        """The conditions that others may share; without an option, it starts at random."""
        for name in CONDITIONS:
            value = self.conditions.get(name, "random" if name == "start" else AUTOMATIC)
            if value != AUTOMATIC:  # what an optimizer chooses by itself, others cannot share
                yield name, value


Descriptions = dict[str, Description]  # by label


def noted(study: Study, note: Mapping[str, Any]) -> Descriptions:
    """Return the descriptions in the note of a folder; built-in optimizers that it lacks are read in this process."""
    labels = [entry.label for entry in study.with_controls]
    described = read(note, labels)
    lacking = any(loading.is_built_in(entry.name) for entry in study.with_controls if entry.label not in described)
    return {label: Description() for label in labels} | (accepting(study, _here) if lacking else {}) | described


def accepting(study: Study, describe: Callable[[Study], Descriptions]) -> Descriptions:
    """Describe a study's optimizers, with the conditions that each of them accepts of the others."""
    described = describe(study)
    shared = {pair for entry in study.optimizers for pair in described[entry.label].shareable}
    asked = [
        (entry, name, value)
        for entry in study.optimizers
        for name, value in sorted(shared)
        if described[entry.label].conditions.get(name, value) != value
    ]
    if not asked:
        return described
    tried = tuple(
        Entry(entry.name, f"{number}", entry.options | {name: value_of(value)})
        for number, (entry, name, value) in enumerate(asked)
    )
    answers = describe(replace(study, optimizers=tried, controls=(), looks=()))
    for (entry, name, value), attempt in zip(asked, tried, strict=True):
        if answers[attempt.label].conditions.get(name) == value:
            described[entry.label].accepts.setdefault(name, []).append(value)
    return described


def _here(study: Study) -> Descriptions:
    """Return the descriptions of the optimizers that come with the harness, and empty ones of the others."""
    built_in = [entry.label for entry in study.with_controls if loading.is_built_in(entry.name)]
    empty = {entry.label: Description() for entry in study.with_controls}
    return empty | read(describe(study, built_in), built_in)


def describe(study: Study, labels: list[str]) -> dict[str, Any]:
    """Return BibTeX, parameters and defaults of optimizers by label, without those that cannot be loaded.

    ``values`` and ``defaults`` are texts by name of the parameter. A class attribute of the name of a condition that
    reports compare (:data:`bench.optimizer.CONDITIONS`) counts as a parameter without a choice.
    """
    described: dict[str, Any] = {}
    for label in labels:
        with suppress(Exception):  # a plug-in may raise anything
            optimizer = study.optimizer(label)
            chosen = settings(optimizer)
            fixed = {
                name: getattr(optimizer, name) for name in CONDITIONS if name not in chosen and hasattr(optimizer, name)
            }
            described[label] = {
                "bibtex": optimizer.bibtex,
                "values": {name: option(value) for name, value in (chosen | fixed).items()},
                "defaults": {name: option(value) for name, value in (defaults(optimizer) | fixed).items()},
            }
    return described


def value_of(text: str) -> Any:
    """Return the value that a text of :func:`bench.helpers.text.option` stands for."""
    try:
        return parse_json(text)
    except ValueError:
        return text


def read(answer: Any, labels: Iterable[str]) -> Descriptions:
    """Return the descriptions in an answer or a note, which may hold anything."""
    described = answer if isinstance(answer, dict) else {}
    return {
        label: Description(
            bibtex if isinstance(bibtex := fields.get("bibtex"), str) else "",
            _texts(fields.get("values")),
            _texts(fields.get("defaults")),
            _lists(fields.get("accepts")),
        )
        for label in labels
        if isinstance(fields := described.get(label), dict)
    }


def _texts(texts: Any) -> Values | None:
    if not isinstance(texts, dict):
        return None
    return {
        printable(name, LONGEST): " ".join(printable(text, LONGEST).split())
        for name, text in texts.items()
        if isinstance(name, str) and isinstance(text, str)
    }


def _lists(lists: Any) -> dict[str, list[str]]:
    return {
        name: [text for text in values if isinstance(text, str)]
        for name, values in (lists if isinstance(lists, dict) else {}).items()
        if isinstance(values, list)
    }


def repairing(study: Study) -> dict[str, bool]:
    """Return by label whether an optimizer repairs its points: not with ``handling="box"``.

    An optimizer without such an option is assumed to repair them. A stranger's is not loaded to look for it.
    """

    def handling(entry: Entry) -> object:
        asked = entry.options.get("handling")
        if not loading.is_built_in(entry.name):
            return asked
        try:
            return getattr(study.optimizer(entry.label), "handling", asked)
        except Exception:  # its library may be missing, and may raise anything
            return asked

    return {entry.label: handling(entry) != "box" for entry in study.optimizers}
