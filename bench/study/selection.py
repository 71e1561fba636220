"""Select a part of a study: optimizers and problems by patterns of their labels, and problems by dimension."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from fnmatch import fnmatchcase

from bench.contract.families import function_of
from bench.helpers.errors import BenchError, nearest
from bench.study.entries import Entry
from bench.study.study import Study

Patterns = str | Iterable[str] | None
Dimensions = int | Iterable[int] | None


def selected(
    study: Study, optimizers: Patterns, problems: Patterns, dimensions: Dimensions, dimension_of: Callable[[str], int]
) -> Study:
    """Return a study of some of its optimizers and problems, in its order.


    Args:
        study: the whole one.
        optimizers: one or more labels or patterns such as ``"gwo*"``; None for all.
        problems: likewise; a pattern may also match the label without its instance, as reports name a function.
        dimensions: one or more dimensions of problems; None for all.
        dimension_of: returns the dimension of the problem of a label.

    Raises:
        BenchError: for a pattern or a dimension that no entry has, and where no problem has both.
    """
    kept = _matching(study.optimizers, optimizers, "optimizer", lambda label: {label})
    chosen = _matching(study.problems, problems, "problem", lambda label: {label, function_of(label)})
    if dimensions is not None:
        wanted = {dimensions} if isinstance(dimensions, int) else set(dimensions)
        size = {entry.label: dimension_of(entry.label) for entry in study.problems}
        if strange := sorted(wanted - set(size.values())):
            there = ", ".join(map(str, sorted(set(size.values()))))
            raise BenchError(f"no problem of study {study.name!r} has dimension {strange[0]}; known: {there}")
        chosen = tuple(entry for entry in chosen if size[entry.label] in wanted)
    if not (kept and chosen):
        raise BenchError(f"nothing of study {study.name!r} is selected; give other patterns or dimensions")
    if (kept, chosen) == (study.optimizers, study.problems):
        return study
    return replace(study, optimizers=kept, problems=chosen)


def _matching(
    entries: tuple[Entry, ...], patterns: Patterns, kind: str, names: Callable[[str], set[str]]
) -> tuple[Entry, ...]:
    """Return the entries of which a name is one of the patterns, or else matches one."""
    if patterns is None:
        return entries
    found: set[str] = set()
    for pattern in [patterns] if isinstance(patterns, str) else patterns:
        labels = [entry.label for entry in entries]
        matched = [label for label in labels if pattern in names(label)] or [
            label for label in labels if any(fnmatchcase(name, pattern) for name in names(label))
        ]
        if not matched:
            raise BenchError(f"no {kind} of the study matches {pattern!r}{nearest(pattern, labels)}")
        found |= set(matched)
    return tuple(entry for entry in entries if entry.label in found)
