"""Find what of a study was changed after its first results: by its history, or as far as the page itself shows it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from bench.analysis.integrity import undeclared
from bench.report.wording import count
from bench.topics.findings import Findings

Record = Mapping[str, Any]


class Changes(NamedTuple):
    """What the page shows otherwise than the first run had planned it.

    Attributes:
        known: whether every folder has a record of what its runs selected.
        made: the changes, a few words each.
    """

    known: bool
    made: tuple[str, ...]


def changes(findings: Findings) -> Changes:
    """Return how the page differs from the first run with the seed of the study; a new seed is a new study."""
    results, shown = findings.results, findings.results.study
    records = [[each for each in history if each.get("seed") == shown.seed] for history in results.histories]
    known, made = all(records), list[str]()
    subjects = {findings.subject, findings.subject.rpartition("@")[0] or findings.subject}  # a version is no other one
    oldest = sorted((each for history in records for each in history), key=lambda each: str(each.get("when", "")))
    firsts = [min(history, key=lambda each: str(each.get("when", ""))) for history in records if history]
    if known:
        own = {
            "problem": [entry.label for entry in shown.problems],
            "optimizer": [entry.label for entry in shown.optimizers],
        }
        for kind, labels in own.items():
            before = {label for first in firsts for label in first.get(f"{kind}s", [])}
            ever = {label for each in oldest for label in each.get(f"{kind}s", [])}
            if len(records) == 1:
                made += _counted(kind, "added", len(set(labels) - before))
                made += _counted(kind, "removed", len(ever - set(labels)))
        for first, history in zip(firsts, records, strict=True):
            most = max(int(each.get("trials", 0)) for each in history)
            if most != (least := int(first.get("trials", 0))):
                made.append(f"trials extended from {least:,} to {most:,}")
            if any(each.get("budget") != first.get("budget") for each in history):
                made.append("another budget")
        if any((first.get("subject") or "") not in subjects for first in firsts):
            made.append("subject named late" if findings.subject else "subject dropped")
    else:
        if (shown.optimizers, shown.problems) != (results.whole.optimizers, results.whole.problems):
            made.append("a selection of optimizers or problems")
        made += [
            f"trials extended from {held:,} to {asked:,}" for held, asked in undeclared(findings.trials.extensions)
        ]
        if findings.subject and findings.first_subject not in subjects:
            made.append("subject named late")
    several = [label for label, (_, every) in results.versions.items() if every > 1]
    if several or results.beside:
        made.append(f"versions of {count(len(several) or len(results.beside), 'optimizer')} chosen")
    return Changes(known, tuple(dict.fromkeys(made)))


def _counted(kind: str, how: str, number: int) -> list[str]:
    return [f"{count(number, kind)} {how}"] if number else []
