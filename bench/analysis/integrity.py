"""Check a study's own records for the known traps of benchmarking.

The traits of an optimizer that leave no sign in the results of a study need runs of their own: ``bench check`` makes
them and records what it finds in the study's folder.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import pandas as pd

from bench.analysis.cells import Budgets, Traces, coverage
from bench.analysis.comparable import blames_problem
from bench.analysis.finished_trials import (
    CHECKS,
    Boxes,
    CheckResult,
    Evidence,
    Verdict,
    cell_names,
    judge,
    percent,
    where,
)
from bench.helpers.parsing import JsonObject
from bench.helpers.text import count, listed

Diagnoses = Mapping[str, Sequence[JsonObject]]


WORST: tuple[Verdict, ...] = ("error", "warning", "pass", "not checked")


class Trait(NamedTuple):
    """The parts of a sentence on a trait of optimizers that ``bench check`` looks for."""

    trouble: str  # what was observed of the optimizers that have the trait
    meaning: str  # the consequence for conclusions
    shown: Callable[[float], str]  # formats the number that decided about an optimizer
    well: str  # what was not found, and is not shown to be absent; goes before "any of the 5 optimizers"


TRAITS = {
    "centre bias": Trait(  # Kudela 2022
        "Errors are higher when the optimum is moved away from the centre of the box",
        "Results on problems with a central optimum flatter these optimizers.",
        lambda ratio: f"{ratio:.2g} times",
        "A central optimum did not lower the errors beyond the limit of the check for",
    ),
    "structural bias": Trait(  # Kononova et al. 2015
        "On pure noise, where no point is better than another, the best points are not uniform in the box",
        "Results depend on where in the box the optimum lies.",
        lambda p: f"p = {p:.1g}",
        "The tests did not reject uniform best points on pure noise for",
    ),
    "boundary clamping": Trait(
        "Best points have coordinates on a bound of the box where no optimum lies there",
        "Results on problems with an optimum on a bound flatter these optimizers.",
        lambda share: f"{percent(share)} of them",
        "The share of coordinates on a bound of the box was not above the limit for",
    ),
    "starts and seeds": Trait(
        "Starting points are not uniform and independent in the box, or runs with different seeds are equal",
        "Trials may not be independent.",
        lambda p: f"p = {p:.1g}",
        "No run repeated one with another seed, and the tests did not reject uniform and independent starts for",
    ),
}


def integrity(
    frame: pd.DataFrame,
    *,
    study_budget: Budgets,
    planned_trials: int | Mapping[tuple[str, str], int],
    traces: Traces | None = None,
    boxes: Boxes | None = None,
    optima: Mapping[str, float] | None = None,
    diagnoses: Diagnoses | None = None,
    verifications: Sequence[JsonObject] = (),
    stored: int = 0,
) -> pd.DataFrame:
    """Return one row a check, always the same checks in the same order: check, verdict, finding and cells.

    The ``verdict`` is "pass", "warning" (conclusions may not hold), "error" (trials failed, are not independent or are
    not what the harness wrote) or "not checked" (there is no trial, or no ``traces``, ``boxes``, ``optima``,
    ``diagnoses``, ``verifications`` or ``stored``). The ``finding`` gives the reason, a line for each part of the
    check; ``cells`` names every "optimizer on problem" concerned, separated by semicolons.

    Args:
        frame: the trials; an optional column ``pool`` names the problem of the study of which the row's problem is an
            instance, or the row's problem itself.
        study_budget: evaluations that each trial was allowed, or those by problem or by (problem, optimizer).
        planned_trials: trials that each cell should hold, or those by problem and optimizer, 0 where no plan is known.
        boxes: the lower and upper bound of each variable, by problem and by variable.
        optima: the known optima, by problem.
        diagnoses: the results of ``bench check`` for each optimizer, by label: check, passed and, where there is one,
            figure (the number that decided).
        verifications: the record of ``bench verify`` in each folder
            (``VERIFICATION`` of :mod:`bench.storage.folder`), empty where there is none.
        stored: the trials that were compared with their digests as they were read (:attr:`bench.Results.stored`).
    """
    findings = {
        "completeness": [_completeness(frame, planned_trials)],
        "failures": [_failures(frame)],
        "storage": [_storage(stored)],
        "repeatability": [_repeatability(verifications)],
        **{name: [_trait(name, diagnoses or {})] for name in TRAITS},
    }
    evidence = Evidence(frame, study_budget, traces or {}, boxes or {}, optima or {})
    none = CheckResult("not checked", "There is no finished trial.")
    finished = bool((frame["status"] == "ok").any())
    for name, checks in CHECKS.items():
        findings.setdefault(name, []).extend([check(evidence) for check in checks] if finished else [none])
    rows = [
        (name, together.verdict, together.text, "; ".join(together.cells))
        for name, parts in findings.items()
        for together in [_together(parts)]
    ]
    return pd.DataFrame(rows, columns=["check", "verdict", "finding", "cells"])


def _together(parts: Sequence[CheckResult]) -> CheckResult:
    """Return one finding of the parts of a check: the worst verdict, and a line on each part that has it."""
    worst = next(verdict for verdict in WORST for part in parts if part.verdict == verdict)
    found = [part for part in parts if part.verdict == worst]
    cells = dict.fromkeys(cell for part in found for cell in part.cells)
    return CheckResult(worst, "\n".join(dict.fromkeys(part.text for part in found)), [*cells])


def _completeness(frame: pd.DataFrame, planned: int | Mapping[tuple[str, str], int]) -> CheckResult:
    table = coverage(frame, planned)
    if "pool" in frame:
        table = table.assign(
            pool=table["problem"].astype(object).map(dict(zip(frame["problem"], frame["pool"], strict=True)))
        )
        made = table.groupby(["pool", "optimizer"], observed=True)["stored"].transform("sum")
        # Folders that are compared may have other instances of a function: there nobody planned a trial.
        table = table[(table["stored"] > 0) | (table["missing"] > 0) | (made == 0)]
    stored, missing = table["stored"], table["missing"]
    if not stored.sum():
        return CheckResult("warning", "There is no trial.")
    span = f"{stored.max():,}" if stored.nunique() == 1 else f"{stored.min():,} to {stored.max():,}"
    short = table[(missing > 0) | (stored == 0)]
    if short.empty and not (planned if isinstance(planned, int) else any(planned.values())):
        return CheckResult("pass", f"No plan of the trials is known: {stored.sum():,} are stored, {span} in each cell.")
    if short.empty:
        return CheckResult("pass", f"All planned trials are stored: {stored.sum():,}, {span} in each cell.")
    text = (
        f"{missing.sum():,} of {(stored + missing).sum():,} planned trials are missing and "
        f"{(stored == 0).sum():,} of {len(table):,} cells are empty. Cells hold {span} trials; fewer than planned: "
        f"{where(short)}."
    )
    return CheckResult("warning", text, cell_names(short))


def _failures(frame: pd.DataFrame) -> CheckResult:
    if frame.empty:
        return CheckResult("not checked", "There is no trial.")
    raised = blames_problem(frame)
    failed = (frame["status"] != "ok") & ~raised
    kinds = [f"{kind} {number:,}" for kind, number in frame.loc[failed, "status"].value_counts().items()]
    well = (
        f"All trials finished but {count(int(raised.sum()), 'trial')} that ended as the problem’s own code raised."
        if raised.any()
        else f"All {len(frame):,} trials finished."
    )
    did = f"did not finish ({listed(kinds)})"
    return judge(frame, failed, "error", did, "They count as +inf.", well=well)


def _storage(stored: int) -> CheckResult:
    if not stored:
        return CheckResult("not checked", "There is no stored trial.")
    return CheckResult("pass", f"All {stored:,} stored trials are as they were written.")


def _repeatability(verifications: Sequence[JsonObject]) -> CheckResult:
    if not verifications or not all(verifications):
        return CheckResult("not checked", "Run 'bench verify' with this folder to repeat trials of each cell.")
    either = (part for noted in verifications for part in (noted.get("at_ends"), noted))
    parts = [part for part in either if isinstance(part, Mapping) and "sentence" in part]
    different = [str(line) for part in parts for line in part.get("different") or ()]
    summary = "; ".join(str(part["sentence"]) for part in parts)
    if different:
        return CheckResult(
            "error", f"{summary}. Not repeated: {listed(different)}. Results depend on more than their seeds."
        )
    return CheckResult("pass", f"Repeated trials: {summary}.")


def _trait(name: str, diagnoses: Diagnoses) -> CheckResult:
    """Return the finding on a trait that ``bench check`` tests, with the optimizers that have it."""
    trait = TRAITS[name]
    diagnosed = [(label, check) for label, checks in diagnoses.items() for check in checks if check["check"] == name]
    if not diagnosed:
        return CheckResult("not checked", "Run 'bench check' with this folder to check the optimizers for it.")
    numbers = [(label, check.get("figure")) for label, check in diagnosed if not check["passed"]]
    if not numbers:
        tested = [label for label, check in diagnosed if check.get("figure") is not None]
        untested = [label for label, check in diagnosed if check.get("figure") is None]
        whom = f"any of the {len(tested):,} optimizers" if len(tested) > 1 else "".join(tested)
        sentences = [f"{trait.well} {whom}."] if tested else []
        sentences += [f"There was nothing to test for {listed(untested)}."] if untested else []
        return CheckResult("pass", " ".join(sentences))
    named = [label if number is None else f"{label} {trait.shown(number)}" for label, number in numbers]
    return CheckResult("warning", f"{trait.trouble}: {listed(named)}. {trait.meaning}")
