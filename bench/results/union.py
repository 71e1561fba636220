"""Make one study of several that are compared, and say how imported results differ from the others."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress

from bench.contract.families import dimension_in, function_of
from bench.helpers.errors import BenchError
from bench.helpers.text import count, joined
from bench.plugins import selection
from bench.study import Entry, Study
from bench.study.budget import Budget
from bench.study.study import LONGEST_NAME, LONGEST_TITLE


def united(studies: Sequence[Study], names: Sequence[str], stored: Callable[[str], int | None]) -> Study:
    """Return one study with the problems and optimizers of all, which are in folders of these names.

    Where one of them is imported, only the problems that all have remain, and the budget is the largest. Functions that
    all have keep the instances of each, where these are repetitions (:func:`compared`). No problem is loaded that is
    not of a suite: its code may be one that nobody trusts.

    Args:
        studies: the studies.
        names: of their folders.
        stored: returns the number of variables that stored trials on a problem have, by its label.

    Raises:
        BenchError: when studies that were run here differ in budget or in the handling of constraints, when a problem's
            label has different options, and when imported results share no problem with the others.
    """
    first, *others = sorted(studies, key=lambda study: bool(study.imported))
    if not others:
        return first
    problems = {entry.label: entry for entry in first.problems}
    for study in others:
        if not study.imported:
            _require_alike(first, study)
        for entry in study.problems:
            if problems.setdefault(entry.label, entry) != entry and not study.imported:
                raise BenchError(
                    f"problem {entry.label!r} has other options in {study.name!r} than in the studies before it; "
                    "only runs on the same problem can be compared"
                )
    if any(study.imported for study in studies):
        shared = compared(studies)
        problems = {label: entry for label, entry in problems.items() if label in shared}
        if not problems:
            raise BenchError(
                f"{' and '.join(names)} have no problem in common, such as {studies[0].problems[0].label!r} and "
                f"{studies[-1].problems[0].label!r}; imported results can be compared on the same problems only"
            )
    return dataclasses.replace(
        first,
        name="-".join(dict.fromkeys(study.name for study in studies))[:LONGEST_NAME],
        title=" beside ".join(dict.fromkeys(study.title or study.name for study in studies))[:LONGEST_TITLE],
        trials=max(study.trials for study in studies),
        budget=_largest(studies, problems, stored),
        problems=tuple(problems.values()),
        optimizers=tuple(entry for study in studies for entry in study.optimizers),
    )


def differences(studies: Sequence[Study], names: Sequence[str]) -> list[str]:
    """Return sentences on how studies differ in problems, dimensions, instances, trials and budgets.

    There are none unless one of them is imported: others are the same in all that matters, or refused.
    """
    if len(studies) == 1 or not any(study.imported for study in studies):
        return []
    shared = compared(studies)
    functions = count(len(set(shared.values())), "problem")
    sentences = [f"The folders share {functions}; only those are compared."]
    pooled = {label for label, function in shared.items() if function != label}
    numbers = [
        {entry.label.rpartition("-i")[2] for entry in study.problems if entry.label in pooled} for study in studies
    ]
    if any(instances != numbers[0] for instances in numbers):
        kept = [
            f"{count(len(instances), 'instance')} of {name}" for instances, name in zip(numbers, names, strict=True)
        ]
        sentences.append(
            "Instances of a function are repetitions, so all runs of a folder on it are pooled, as cocopp does: "
            f"{joined(kept)}. No test pairs single runs; those over all problems pair functions."
        )
    for study, name in zip(studies, names, strict=True):
        if more := [entry.label for entry in study.problems if entry.label not in shared]:
            sentences.append(f"Left out of {name}: {len(more):,} problems that not all folders have, as {more[0]}.")
    if len({study.trials for study in studies}) > 1:
        phrases = [f"{study.trials:,} in {name}" for study, name in zip(studies, names, strict=True)]
        sentences.append(f"Trials of an optimizer on a problem differ: at most {joined(phrases)}.")
    if len({str(study.budget) for study in studies}) > 1:
        phrases = [
            f"{'at most ' if study.imported else ''}{study.budget.within(map(dimension_in, shared)).words} in {name}"
            for study, name in zip(studies, names, strict=True)
        ]
        sentences.append(
            f"Budgets differ: {joined(phrases)}. Values are compared at the largest budget that all had; running times "
            "to targets count what each trial spent."
        )
    return sentences


def _require_alike(first: Study, study: Study) -> None:
    for what, one, other in (
        ("budget", first.budget, study.budget),
        ("handling of constraints", first.rules.constraints, study.rules.constraints),
    ):
        if one != other:
            raise BenchError(
                f"study {first.name!r} has the {what} {one!r}, and {study.name!r} {other!r}; only runs of one {what} "
                "can be compared"
            )


def compared(studies: Sequence[Study]) -> dict[str, str]:
    """Return the name under which each problem is compared, by label, of those that all studies have.

    That is its function in a dimension where instances are repetitions by construction, as those of COCO's suites are:
    each study may have other ones. Elsewhere it is the problem itself.
    """
    repeated: dict[str, bool] = {}
    functions: dict[str, str] = {}
    for study in studies:
        for entry in study.problems:
            function = function_of(entry.label)
            if function not in repeated:
                repeated[function] = function != entry.label and _is_known(study, entry)
            functions[entry.label] = function if repeated[function] else entry.label
    shared = set.intersection(*({functions[entry.label] for entry in study.problems} for study in studies))
    return {label: function for label, function in functions.items() if function in shared}


def _is_known(study: Study, entry: Entry) -> bool:
    """Return whether an entry is an instance of a suite's function with a known optimum, which a report then pools."""
    if entry.label != entry.name or not selection.is_of_suite(entry.name):
        return False
    with suppress(Exception):  # a plug-in may raise anything
        problem = study.problem(entry.label)
        return problem.optimum is not None and "instance" in problem.features
    return False


def _largest(studies: Sequence[Study], problems: Iterable[str], stored: Callable[[str], int | None]) -> Budget:
    """Return the largest budget of all studies, by dimension where it depends on that."""
    budgets = [study.budget for study in studies]
    if all(budget == budgets[0] for budget in budgets):
        return budgets[0]
    if all(budget.number for budget in budgets):
        return max(budgets, key=lambda budget: budget.number or 0)
    dimensions = {label: dimension_in(label) or stored(label) for label in problems}
    if unknown := [label for label, dimension in dimensions.items() if not dimension]:
        raise BenchError(
            f"budgets depend on the dimension, and that of problem {unknown[0]!r} is not known: no folder holds a "
            "finished trial on it"
        )
    sizes = sorted({dimension for dimension in dimensions.values() if dimension})
    return Budget.read({str(size): max(study.budget.evaluations(size) for study in studies) for size in sizes})
