"""Read the BibTeX and the parameters of a study's optimizers for a report, strangers' in processes that can be lost."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from bench.errors import BenchError
from bench.execution import trial_process
from bench.execution.job import root
from bench.helpers.text import printable
from bench.plugins import loading
from bench.sandbox.process import FAILURES, LostError
from bench.study import Study

LOADING = 60.0  # seconds for loading the optimizers of one package
LONGEST = 200  # characters of a value


@dataclass(frozen=True)
class Description:
    """An optimizer as its plug-in describes it here.

    Attributes:
        bibtex: the works that introduced it; "" where the plug-in is missing here or gives no text.
        values: its parameters as texts, by name; None where it cannot be loaded, so that they are not known.
        defaults: likewise, without a parameter that has no default.
    """

    bibtex: str = ""
    values: dict[str, str] | None = None
    defaults: dict[str, str] | None = None


def describe(study: Study, sandbox: str | None = None) -> dict[str, Description]:
    """Return the description of each optimizer and control by label.

    Only the optimizers that come with the harness are imported here.

    Args:
        study: whose optimizers are meant.
        sandbox: in which the study was run; where it cannot be used here, strangers' optimizers are not read.
    """
    built_in = [entry.label for entry in study.with_controls if loading.is_built_in(entry.name)]
    strange = [labels for labels in study.packages().values() if not {*labels} & {*built_in}]
    found = {entry.label: Description() for entry in study.with_controls}
    found |= _read(trial_process.descriptions_of(study, built_in), built_in)
    if strange:
        with suppress(BenchError, LostError, *FAILURES), root(study, sandbox) as server:
            server.call(trial_process.begin, study, seconds=LOADING)
            for labels in strange:
                with suppress(LostError, *FAILURES), server.process() as process:
                    found |= _read(process.call(trial_process.descriptions, labels, seconds=LOADING), labels)
    return found


def _read(answer: Any, labels: Iterable[str]) -> dict[str, Description]:
    """Return the descriptions in an answer, which may hold anything."""
    given = answer if isinstance(answer, dict) else {}
    return {
        label: Description(
            bibtex if isinstance(bibtex := each.get("bibtex"), str) else "",
            _texts(each.get("values")),
            _texts(each.get("defaults")),
        )
        for label in labels
        if isinstance(each := given.get(label), dict)
    }


def _texts(given: Any) -> dict[str, str] | None:
    if not isinstance(given, dict):
        return None
    return {
        printable(name, LONGEST): " ".join(printable(text, LONGEST).split())
        for name, text in given.items()
        if isinstance(name, str) and isinstance(text, str)
    }
