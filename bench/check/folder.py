"""Diagnose the optimizers of a study's folder for biases, and keep the verdicts on those that have not changed."""

from __future__ import annotations

import json
import platform
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass

from bench.check import bias
from bench.check.conformance.subject import Subject
from bench.check.verdict import Verdict
from bench.contract.optimizer import Optimizer
from bench.execution.job import sandbox_of_optimizers
from bench.helpers.errors import BenchError
from bench.helpers.text import short_hash
from bench.plugins.inputs import Inputs, Present
from bench.storage import provenance
from bench.storage.cells import Cells
from bench.storage.folder import CHECKS, Folder
from bench.study import Entry


@dataclass(frozen=True)
class Diagnosis:
    """The diagnosis of one optimizer of a study.

    Attributes:
        label: the optimizer's label.
        verdicts: the verdicts on its biases, empty where it failed.
        failed: why it could not be diagnosed, "" where it could.
        kept: whether the verdicts are those of an earlier check of the same code with the same parameters.
    """

    label: str
    verdicts: list[Verdict]
    failed: str = ""
    kept: bool = False


def diagnose_folder(
    folder: Folder, n_jobs: int = -1, *, untrusted: bool = False, **settings: object
) -> Iterator[Diagnosis]:
    """Yield a diagnosis of every optimizer of a study, with its own options; each is noted in the folder for reports.

    Args:
        folder: the folder of a study.
        n_jobs: runs made at a time, -1 for one a core.
        untrusted: whether to load and run all of them in a sandbox alone; they are then diagnosed anew each time.
        settings: others of :func:`bench.check.runs.make_runs`.
    """
    study, noted = folder.study(), folder.checks()
    noted = {entry.label: noted[entry.label] for entry in study.optimizers if entry.label in noted}
    held = folder.store.held()
    changed: dict[str, tuple[Optimizer | Subject, str]] = {}  # with the key of its verdicts
    apart = sandbox_of_optimizers(entry.name for entry in study.optimizers) if untrusted else None
    for entry in study.optimizers:
        if apart:
            changed[entry.label] = Subject(entry.name, entry.options), ""
            continue
        try:
            optimizer = study.optimizer(entry.label)
            code = key(entry, made_from(held, entry.label))
        except BenchError as error:  # the other optimizers get their verdicts all the same
            noted.pop(entry.label, None)
            yield Diagnosis(entry.label, [], str(error))
            continue
        kept = [] if not code else _kept([dict(record) for record in noted.get(entry.label, [])], code)
        if kept:
            yield Diagnosis(entry.label, kept, kept=True)
        else:
            changed[entry.label] = optimizer, code
    optimizers = [optimizer for optimizer, _ in changed.values()]
    verdicts = bias.diagnose_all(optimizers, n_jobs=n_jobs, sandbox=apart, **settings)
    for (label, (_, code)), outcome in zip(changed.items(), verdicts, strict=True):
        if isinstance(outcome, BenchError):
            noted.pop(label, None)
            diagnosis = Diagnosis(label, [], str(outcome))
        else:
            noted[label] = [verdict.as_dict() | {"code": code} for verdict in outcome]
            diagnosis = Diagnosis(label, outcome)
        folder.note(CHECKS, noted)
        yield diagnosis
    folder.note(CHECKS, noted)


def made_from(held: Cells, label: str) -> Inputs:
    """Return what the shown trials of an optimizer were made from, its problems' inputs included."""
    cells = [cell for labels, cell in held.by_labels.items() if labels[1] == label]
    return {name: known for cell in cells for part in held.made_from(cell) for name, known in part.items()}


def key(entry: Entry, made: Inputs) -> str:
    """Return a hash of all that verdicts on an optimizer depend on: its code, its parameters, and the checks' code.

    The code is what its trials were ``made`` from, with the versions of what this package uses; "" where that is not
    known, or is other code now.
    """
    if not made or Present().changed(made):
        return ""
    about: list[object] = [
        provenance.package(), platform.python_version(), provenance.package_versions(),
        {name: state for name, (state, _) in made.items()}, entry.name, entry.options,
    ]  # fmt: skip
    return short_hash(json.dumps(about, sort_keys=True, default=str))


def _kept(noted: list[dict[str, object]], code: str) -> list[Verdict]:
    """Return the noted verdicts where they are those of all checks of this code, else none."""
    if len(noted) == len(bias.CHECKS) and all(record.pop("code") == code for record in noted):
        with suppress(ValueError):  # the file was edited
            return [Verdict.from_dict(record) for record in noted]
    return []
