"""Find what of a study was changed after its first results: by its history, or as far as the page itself shows it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from bench.helpers.parsing import JsonObject
from bench.report.wording import count
from bench.topics.findings import Findings


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
    firsts = [history[0] for history in records if history]
    if known:
        own = {
            "problem": [entry.label for entry in shown.problems],
            "optimizer": [entry.label for entry in shown.optimizers],
        }
        for kind, labels in own.items():
            before = {label for first in firsts for label in first.get(f"{kind}s", [])}
            ever = {label for history in records for each in history for label in each.get(f"{kind}s", [])}
            if len(records) == 1:
                made += _counted(kind, "added", len(set(labels) - before))
                made += _counted(kind, "removed", len(ever - set(labels)))
        for first, history in zip(firsts, records, strict=True):
            if grown := extended(history):
                made.append("trials extended from {:,} to {:,}".format(*grown))
            if any(each.get("budget") != first.get("budget") for each in history):
                made.append("another budget")
        if any((first.get("subject") or "") not in subjects for first in firsts):
            made.append("subject named late" if findings.subject else "subject dropped")
    else:
        if (shown.optimizers, shown.problems) != (results.whole.optimizers, results.whole.problems):
            made.append("a selection of optimizers or problems")
        if findings.subject and findings.first_subject not in subjects:
            made.append("subject named late")
    several = [label for label, (_, every) in results.versions.items() if every > 1]
    if several or results.beside:
        made.append(f"versions of {count(len(several) or len(results.beside), 'optimizer')} chosen")
    return Changes(known, tuple(dict.fromkeys(made)))


def extended(history: Sequence[JsonObject]) -> tuple[int, int] | None:
    """Return the trials that the first run of a history was asked for, and the most of a later one; None for no more.

    Only runs with the seed of the last one count: another seed makes other trials.
    """
    asked = [int(each.get("trials", 0)) for each in history if each.get("seed") == history[-1].get("seed")]
    return (asked[0], max(asked)) if asked and max(asked) > asked[0] else None


def _counted(kind: str, how: str, number: int) -> list[str]:
    return [f"{count(number, kind)} {how}"] if number else []
