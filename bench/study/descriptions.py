"""Descriptions of a study's optimizers: BibTeX and parameters.

A run reads them where it checks the study, in processes that can be lost, and notes them in its folder, so that a
report starts no process and loads no stranger's code.
"""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass

from bench.contract.optimizer import CONDITIONS, defaults, settings
from bench.helpers.parsing import JsonObject
from bench.helpers.text import option, printable
from bench.plugins import loading
from bench.study.entries import Entry
from bench.study.study import Study

LONGEST = 200  # characters of a value

Values = dict[str, str]  # of parameters, as texts by name


@dataclass(frozen=True)
class Description:
    """An optimizer as its plug-in describes it where it was run.

    Attributes:
        bibtex: the works that introduced it; "" where the plug-in is missing there or gives no text.
        values: its parameters as texts, by name; None where it cannot be loaded, so that they are not known.
        defaults: likewise, without a parameter that has no default.
    """

    bibtex: str = ""
    values: Values | None = None
    defaults: Values | None = None


Descriptions = dict[str, Description]  # by label


def noted(study: Study, note: JsonObject) -> Descriptions:
    """Return the descriptions in the note of a folder; built-in optimizers that it lacks are read in this process."""
    labels = [entry.label for entry in study.optimizers]
    described = read(note, labels)
    built_in = [entry.label for entry in study.optimizers if loading.is_built_in(entry.name)]
    lacking = [label for label in built_in if label not in described]
    return {label: Description() for label in labels} | read(describe(study, lacking), lacking) | described


def describe(study: Study, labels: list[str]) -> JsonObject:
    """Return BibTeX, parameters and defaults of optimizers by label, without those that cannot be loaded.

    ``values`` and ``defaults`` are texts by name of the parameter. A class attribute of the name of a condition that
    reports compare (:data:`bench.contract.optimizer.CONDITIONS`) counts as a parameter without a choice.
    """
    described: JsonObject = {}
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


def read(answer: object, labels: Iterable[str]) -> Descriptions:
    """Return the descriptions in an answer or a note, which may hold anything."""
    described = answer if isinstance(answer, dict) else {}
    return {
        label: Description(
            bibtex if isinstance(bibtex := fields.get("bibtex"), str) else "",
            _texts(fields.get("values")),
            _texts(fields.get("defaults")),
        )
        for label in labels
        if isinstance(fields := described.get(label), dict)
    }


def _texts(texts: object) -> Values | None:
    if not isinstance(texts, dict):
        return None
    return {
        printable(name, LONGEST): " ".join(printable(text, LONGEST).split())
        for name, text in texts.items()
        if isinstance(name, str) and isinstance(text, str)
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
