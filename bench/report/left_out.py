"""Say in sentences what of a study is not shown or not compared, and why."""

from __future__ import annotations

from collections.abc import Mapping

from bench.analysis.comparable import Comparable
from bench.report.wording import count, listing
from bench.study import Study
from bench.study.blocks import pooled

NAMED = 6  # problems, or optimizers, that a sentence names


def selection(whole: Study, shown: Study, *, by_instance: bool) -> str:
    """Return what was selected from and what is left out, in a sentence; "" where a report shows the whole study.

    Args:
        whole: the study as it was run.
        shown: what of it was selected.
        by_instance: whether the instances of a function are problems of their own, and not one.
    """
    groups = {
        "optimizer": [[entry.label for entry in study.optimizers] for study in (whole, shown)],
        "problem": [
            list(dict.fromkeys(entry.label if by_instance else pooled(entry.label) for entry in study.problems))
            for study in (whole, shown)
        ],
    }
    missing = {kind: [label for label in every if label not in kept] for kind, (every, kept) in groups.items()}
    parts = [f"{count(len(labels), kind)} ({listing(labels, NAMED)})" for kind, labels in missing.items() if labels]
    if not missing["problem"] and (fewer := len(whole.problems) - len(shown.problems)):
        parts.append(f"{fewer:,} of {count(len(whole.problems), 'instance')}")
    every = [count(len(labels), kind) for kind, (labels, _) in groups.items()]
    return f"Selected from {listing(every)} after the results were seen; left out: {listing(parts)}." if parts else ""


def versions(numbers: Mapping[str, tuple[int, int]]) -> str:
    """Return how often optimizers were changed in the folder, in a sentence; "" where each has one version.

    ``numbers`` are the version that is shown and the number of versions, by label (:attr:`bench.Results.versions`).
    """
    parts = [
        f"{label} is version {number} of {every} run here" for label, (number, every) in numbers.items() if every > 1
    ]
    return f"{listing(parts, NAMED)}; the others are not shown." if parts else ""


def left_out(found: Comparable) -> tuple[str, ...]:
    """Return a sentence for each reason for which something is not compared."""
    return tuple(filter(None, (_failed(found), *_instances(found), *_unknown(found))))


def _failed(found: Comparable) -> str:
    """Return whose own code raised, which says nothing about an optimizer."""
    named = [
        f"{problem} (in {raised:,} of {count(trials, 'trial')})" for problem, (raised, trials) in found.failed.items()
    ]
    one = len(named) == 1
    which, whose = ("problem that failed is", "its") if one else (f"{len(named)} problems that failed are", "their")
    return (
        f"The {which} not compared, as {whose} own code raised, not an optimizer’s: {listing(named, NAMED)}."
        if named
        else ""
    )


def _instances(found: Comparable) -> list[str]:
    """Return on which problems the optimizers share some instances, and on which none."""
    some = [f"{shared} of {every} on {problem}" for problem, (shared, every) in found.instances.items() if shared]
    none = [problem for problem, (shared, _) in found.instances.items() if not shared]
    sentences = []
    if some:
        sentences.append(
            f"Final values are compared on the instances that all optimizers share ({listing(some, NAMED)}); running "
            "times to targets count all instances."
        )
    if none:
        sentences.append(f"The optimizers share no instance of {listing(none, NAMED)}, so they are not compared there.")
    return sentences


def _unknown(found: Comparable) -> list[str]:
    """Return which optimizers spent more than the common budget without a trace, on which problems."""
    problems: dict[str, list[str]] = {}
    for problem, optimizer in found.unknown:
        problems.setdefault(optimizer, []).append(problem)
    together: dict[tuple[str, ...], list[str]] = {}
    for optimizer, labels in problems.items():
        together.setdefault(tuple(labels), []).append(optimizer)
    return [
        f"{listing(owners, NAMED)} spent more evaluations than others had on {listing(labels, NAMED)}, and what was "
        f"found by then is not known, so {'it is' if len(owners) == 1 else 'they are'} not compared there."
        for labels, owners in together.items()
    ]
