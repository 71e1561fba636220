"""Say in sentences what of a study a report does not show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from bench.contract.families import function_of
from bench.report.wording import count, listing
from bench.study import Study

NAMED = 6  # problems, or optimizers, that a sentence names


def selection(whole: Study, shown: Study, *, by_instance: bool) -> str:
    """Return a sentence on the selection and on what it leaves out; "" where a report shows the whole study.

    Args:
        whole: the study as it was run.
        shown: what of it was selected.
        by_instance: whether the instances of a function are problems of their own, and not one.
    """
    groups = {
        "optimizer": [[entry.label for entry in study.optimizers] for study in (whole, shown)],
        "problem": [
            list(dict.fromkeys(entry.label if by_instance else function_of(entry.label) for entry in study.problems))
            for study in (whole, shown)
        ],
    }
    missing = {kind: [label for label in every if label not in kept] for kind, (every, kept) in groups.items()}
    parts = [f"{count(len(labels), kind)} ({listing(labels, NAMED)})" for kind, labels in missing.items() if labels]
    if not missing["problem"] and (fewer := len(whole.problems) - len(shown.problems)):
        parts.append(f"{fewer:,} of {count(len(whole.problems), 'instance')}")
    every = [count(len(labels), kind) for kind, (labels, _) in groups.items()]
    return f"Selected from {listing(every)} after the results were seen; left out: {listing(parts)}." if parts else ""


def versions(numbers: Mapping[str, tuple[int, int]], beside: Sequence[str] = ()) -> str:
    """Return how often optimizers were changed in the folder, in sentences; "" where each has one version.

    ``numbers`` are the version that is shown and the number of versions, by label (:attr:`bench.Results.versions`);
    ``beside`` are those whose earlier versions are shown, too (:attr:`bench.Results.beside`).
    """
    parts = [
        f"{label} is version {number} of {every} run here" for label, (number, every) in numbers.items() if every > 1
    ]
    alone = f"{listing(parts, NAMED)}; the others are not shown." if parts else ""
    chosen = f"The versions before {listing(beside, NAMED)} are shown beside it, chosen after the results were seen."
    return " ".join(filter(None, (chosen if beside else "", alone)))
