"""Whether a study that was registered before its first trial was made as registered, or what differs."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from bench.errors import BenchError
from bench.report.parts import Section
from bench.report.wording import count, listing
from bench.storage.folder import REGISTRATION, Folder
from bench.study import Study
from bench.study.cell import alike, differences
from bench.study.values import Value
from bench.topics.findings import Findings
from bench.topics.registration.register import Registered, read
from bench.topics.topic import Topic

TITLE = "Registration"
APART = {"name", "title", "parallel", "controls", "tuning", "problems", "optimizers"}
"""Fields of a study that decide no comparison, and those that are compared entry by entry."""

PROOF = (
    f"The date is that of the machine that wrote {REGISTRATION}. Its hash shows an edit and prevents no forgery; a "
    "copy elsewhere, such as in a repository or a registry, proves the date."
)


class Followed(NamedTuple):
    """Sentences on the registrations of the folders shown, and warnings of differences from the study."""

    text: tuple[str, ...]
    differing: tuple[str, ...]


def section(findings: Findings) -> Section | None:
    """Return whether the study was made as registered; None for folders without a registration."""
    found = findings.of(followed)
    return Section(TITLE, (*found.text, PROOF), warnings=found.differing) if any(found) else None


def followed(findings: Findings) -> Followed:
    """Return whether the registration of each folder was followed, and what differs; nothing without any."""
    text, warnings, paths = list[str](), list[str](), findings.results.paths
    for path in paths:
        where = "" if len(paths) == 1 else f"{path}: "
        with suppress(FileNotFoundError):
            try:
                registered = read(path / REGISTRATION)
            except BenchError as error:
                warnings.append(f"{where}Nothing follows from the registration: {error}.")
                continue
            differing = [*_differing(registered, findings, path)]
            points = f"differs from this in {count(len(differing), 'point')}"
            outcome = f"What was run, or is shown here, {points}." if differing else "It was made as registered."
            text.append(f"{where}The study was registered on {registered.date}. {outcome}")
            warnings += [f"{where}{each}" for each in differing]
    if len(paths) > 1 and (text or warnings):
        text.append("The comparison of these folders with each other was not registered.")
    return Followed(tuple(text), tuple(warnings))


def _differing(registered: Registered, findings: Findings, path: Path) -> Iterator[str]:
    """Yield a sentence on each point in which a folder, or its report, differs from the registration."""
    folder = Folder(path)
    before = [str(run["started"]) for run in folder.environments() if str(run.get("started", "~")) < registered.when]
    if before:
        yield f"Trials were made before the registration, in a run that began on {min(before)}."
    asked = {"targets": findings.asked, "rope": findings.asked_rope, "subject": findings.asked_subject}
    ran = folder.study().override(**asked)
    for field in dataclasses.fields(Study):
        then, now = (getattr(study, field.name) for study in (registered.study, ran))
        if field.name not in APART and then != now:
            yield f"The field {field.name} is {_words(now)}; {_words(then)} was registered."
    for key in ("problems", "optimizers"):
        labels, others = ([entry.label for entry in getattr(study, key)] for study in (registered.study, ran))
        if added := [label for label in others if label not in labels]:
            yield f"Not registered among the {key}: {listing(added, at_most=8)}."
        if gone := [label for label in labels if label not in others]:
            yield f"Registered among the {key}, and not there: {listing(gone, at_most=8)}."
    yield from _changed(registered, folder)
    if findings.results.partial:
        yield "This page shows a selection, which was not registered."
    missing = int(findings.trials.coverage["missing"].sum())
    if missing and len(findings.results.paths) == 1:
        yield f"{count(missing, 'trial')} of those registered {'is' if missing == 1 else 'are'} missing."


def _changed(registered: Registered, folder: Folder) -> Iterator[str]:
    """Yield a sentence for each problem and optimizer whose data, code or options are others than registered."""
    held, sentences = folder.store.held().by_labels, dict[str, None]()
    for labels, cell in registered.study.cells(registered.found).items():
        for label, then, now in zip(labels, cell.records, held[labels].records if labels in held else (), strict=False):
            if not alike(then, now):
                sentences[f"{label} is another one than registered: {'; '.join(differences(then, now))}."] = None
    yield from sentences


def _words(value: object) -> str:
    plain = value.plain if isinstance(value, Value) else value
    return "not set" if plain in (None, "", ()) else str(list(plain) if isinstance(plain, tuple) else plain)


TOPIC = Topic(TITLE, section, place=15)
