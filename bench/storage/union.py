"""Make one study of several that are compared, and say how imported results differ from the others."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Sequence

from bench.errors import BenchError
from bench.families import dimension_in
from bench.helpers.text import joined
from bench.study import Entry, Study
from bench.study.budget import Budget, described


def united(studies: Sequence[Study], names: Sequence[str]) -> Study:
    """Return one study with the problems and optimizers of all, which are in folders of these names.

    Where one of them is imported, only the problems that all have remain, and the budget is the largest.

    Raises:
        BenchError: when studies that were run here differ in budget or in the handling of constraints, when a problem's
            label has different options, and when imported results share no problem with the others.
    """
    first = studies[0]
    if len(studies) == 1:
        return first
    own = [study for study in studies if not study.imported]
    problems: dict[str, Entry] = {}
    for study in [*own, *(study for study in studies if study.imported)]:
        if not study.imported:
            _require_alike(own[0], study)
        for entry in study.problems:
            if problems.setdefault(entry.label, entry) != entry and not study.imported:
                raise BenchError(
                    f"problem {entry.label!r} has other options in {study.name!r} than in the studies before it; "
                    "only runs on the same problem can be compared"
                )
    if len(own) < len(studies):
        shared = _shared(studies)
        problems = {label: entry for label, entry in problems.items() if label in shared}
        if not problems:
            raise BenchError(
                f"{' and '.join(names)} have no problem in common, such as {studies[0].problems[0].label!r} and "
                f"{studies[-1].problems[0].label!r}; imported results can be compared on the same problems only"
            )
    return dataclasses.replace(
        (own or [first])[0],
        name="-".join(dict.fromkeys(study.name for study in studies)),
        title=" beside ".join(dict.fromkeys(study.title or study.name for study in studies)),
        trials=max(study.trials for study in studies),
        budget=_largest(studies, problems),
        problems=tuple(problems.values()),
        optimizers=tuple(entry for study in studies for entry in study.optimizers),
        controls=tuple(entry for study in studies for entry in study.controls),
        looks=(),  # each folder was stopped by its own pairs
    )


def differences(studies: Sequence[Study], names: Sequence[str]) -> list[str]:
    """Return sentences on how studies differ in problems, dimensions, instances, trials and budgets.

    There are none unless one of them is imported: others are the same in all that matters, or refused.
    """
    if len(studies) == 1 or not any(study.imported for study in studies):
        return []
    shared = _shared(studies)
    several = "" if len(shared) == 1 else "s"
    sentences = [f"The folders share {len(shared):,} problem{several}; only those are compared."]
    for study, name in zip(studies, names, strict=True):
        if more := [entry.label for entry in study.problems if entry.label not in shared]:
            parts = _parts(more, shared)
            sentences.append(f"Left out of {name}: {len(more):,} problems that not all folders have{parts}.")
    if len({study.trials for study in studies}) > 1:
        each = [f"{study.trials:,} in {name}" for study, name in zip(studies, names, strict=True)]
        sentences.append(f"Trials of an optimizer on a problem differ: at most {joined(each)}.")
    if len({str(study.budget) for study in studies}) > 1:
        each = [
            f"{'at most ' if study.imported else ''}{described(_within(study.budget, shared))} in {name}"
            for study, name in zip(studies, names, strict=True)
        ]
        sentences.append(
            f"Budgets differ: {joined(each)}. Values are compared at the largest budget that all had; running times "
            "to targets count what each trial spent."
        )
    return sentences


def _require_alike(first: Study, study: Study) -> None:
    if study.budget != first.budget:
        raise BenchError(
            f"study {first.name!r} has a budget of {first.budget_words} and {study.name!r} one of "
            f"{study.budget_words}; only runs of one budget can be compared"
        )
    if study.constraints != first.constraints:
        raise BenchError(
            f"study {first.name!r} handles constraints by {first.constraints!r} and {study.name!r} by "
            f"{study.constraints!r}; only runs of one handling can be compared"
        )


def _shared(studies: Sequence[Study]) -> set[str]:
    """Return the labels of the problems that all studies have."""
    return set.intersection(*({entry.label for entry in study.problems} for study in studies))


def _largest(studies: Sequence[Study], problems: Iterable[str]) -> Budget:
    """Return the largest budget of all studies, by dimension where it depends on that."""
    budgets = [study.budget for study in studies]
    if all(budget == budgets[0] for budget in budgets):
        return budgets[0]
    numbers = [budget for budget in budgets if isinstance(budget, int)]
    if len(numbers) == len(budgets):
        return max(numbers)
    return {
        str(dimension): max(study.evaluations(dimension) for study in studies)
        for dimension in sorted({_dimension(studies, label) for label in problems})
    }


def _dimension(studies: Sequence[Study], label: str) -> int:
    """Return the dimension of a problem, by its name or by loading it; raises BenchError where neither shows it."""
    return dimension_in(label) or next(study for study in studies if not study.imported).problem(label).dimension


def _within(budget: Budget, labels: Iterable[str]) -> Budget:
    """Return a budget by dimension without the dimensions that none of the labels has."""
    if not isinstance(budget, dict):
        return budget
    known = {str(dimension_in(label)) for label in labels}
    return {dimension: most for dimension, most in budget.items() if dimension in known} or budget


def _parts(labels: Iterable[str], shared: set[str]) -> str:
    """Return the dimensions and instances that occur among the labels and not among the shared ones, in words."""
    found = []
    for what, pattern in (("dimensions", r"-d([0-9]+)(?:-i[0-9]+)?$"), ("instances", r"-i([0-9]+)$")):
        own, others = (
            {int(each[1]) for label in group if (each := re.search(pattern, label))} for group in (labels, shared)
        )
        if more := sorted(own - others):
            found.append(f"{what} {_ranges(more)}")
    return f", of {joined(found)} among others" if found else ""


def _ranges(numbers: Sequence[int]) -> str:
    """Return increasing numbers with runs of three or more shortened, as in "2, 3, 5 to 8"."""
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ", ".join(f"{run[0]} to {run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs)
