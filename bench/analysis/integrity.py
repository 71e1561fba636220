"""Check a study's own records for the known traps of benchmarking.

The traits of an optimizer that leave no sign in the results of a study need runs of their own: ``bench check`` makes
them and records what it finds in the study's folder.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import pandas as pd

from bench.analysis.cells import Traces, coverage
from bench.analysis.evidence import (
    Boxes,
    Check,
    Diagnoses,
    Evidence,
    Finding,
    cell_names,
    enumerated,
    judge,
    where,
)
from bench.analysis.finished_trials import OF_FINISHED
from bench.analysis.traits import TRAITS


def integrity(
    frame: pd.DataFrame,
    *,
    study_budget: int,
    planned_trials: int,
    traces: Traces | None = None,
    boxes: Boxes | None = None,
    diagnoses: Diagnoses | None = None,
    verifications: Sequence[Mapping[str, Any]] = (),
) -> pd.DataFrame:
    """Return one row a check, always the same checks in the same order: check, verdict, finding and cells.

    The ``verdict`` is "pass", "note" (nothing is wrong, but a reader should know), "warning" (conclusions may not
    hold), "error" (trials failed, are not independent or are not what the harness wrote) or "not checked" (there is
    no trial, or no ``traces``, ``boxes``, ``diagnoses`` or ``verifications``). The ``finding`` gives the reason in a
    sentence; ``cells`` names every "optimizer on problem" concerned, separated by semicolons.

    Args:
        frame: the tidy frame.
        study_budget: evaluations that each trial was allowed.
        planned_trials: trials that each cell should hold.
        traces: by (problem, optimizer, trial).
        boxes: the lower and upper bound of each variable, by problem and by variable.
        diagnoses: the results of ``bench check`` for each optimizer, by label: check, passed and, where there is one,
            figure (the number that decided).
        verifications: the record of ``bench verify`` in each folder
            (:meth:`bench.storage.folder.Folder.verification`), empty where there is none.
    """
    evidence = Evidence(frame, study_budget, planned_trials, traces or {}, boxes or {}, diagnoses or {}, verifications)
    findings = {name: check(evidence) for name, check in OF_ALL.items()}
    for name, check in OF_FINISHED.items():
        none = evidence.finished.empty
        findings[name] = Finding("not checked", "There is no finished trial.") if none else check(evidence)
    rows = [(name, found.verdict, found.text, "; ".join(found.cells)) for name, found in findings.items()]
    return pd.DataFrame(rows, columns=["check", "verdict", "finding", "cells"])


def _completeness(evidence: Evidence) -> Finding:
    table = coverage(evidence.frame, evidence.planned)
    stored, missing = table["stored"], table["missing"]
    if not stored.sum():
        return Finding("warning", "There is no trial.")
    if not missing.any() and stored.nunique() == 1:
        return Finding("pass", f"All planned trials are stored: {stored.sum():,}, {stored.max():,} in each cell.")
    short = table[stored < stored.max()]
    text = (
        f"{missing.sum():,} of {evidence.planned * len(table):,} planned trials are missing and "
        f"{(stored == 0).sum():,} of {len(table):,} cells are empty."
    )
    if not short.empty:
        text += f" Cells hold {stored.min():,} to {stored.max():,} trials; fewer than others: {where(short)}."
    return Finding("warning", text, cell_names(table[(missing > 0) | (stored < stored.max())]))


def _failures(evidence: Evidence) -> Finding:
    total = len(evidence.frame)
    if not total:
        return Finding("not checked", "There is no trial.")
    status = evidence.frame["status"]
    kinds = status[status != "ok"].value_counts()
    return judge(
        evidence.frame,
        (status != "ok").to_numpy(),
        "error",
        f"did not finish ({enumerated([f'{kind} {count:,}' for kind, count in kinds.items()])})",
        "They count as +inf.",
        well=f"All {total:,} trials finished.",
    )


def _repeatability(evidence: Evidence) -> Finding:
    if not evidence.verifications or not all(evidence.verifications):
        return Finding("not checked", "Run 'bench verify' with this folder to repeat trials of each cell.")
    different = [str(line) for noted in evidence.verifications for line in noted.get("different") or ()]
    summary = "; ".join(str(noted.get("sentence")) for noted in evidence.verifications)
    if different:
        return Finding(
            "error", f"{summary}. Not repeated: {enumerated(different)}. Results depend on more than their seeds."
        )
    return Finding("pass", f"Repeated trials: {summary}.")


def _trait(name: str, evidence: Evidence) -> Finding:
    """Return which optimizers have a trait that ``bench check`` looks for."""
    trait = TRAITS[name]
    found = [(label, each) for label, checks in evidence.diagnoses.items() for each in checks if each["check"] == name]
    if not found:
        return Finding("not checked", "Run 'bench check' with this folder to check the optimizers for it.")
    numbers = [(label, each.get("figure")) for label, each in found if not each["passed"]]
    if not numbers:
        return Finding("pass", f"None of {len(found):,} optimizers {trait.well}.")
    named = [label if number is None else f"{label} {trait.shown(number)}" for label, number in numbers]
    return Finding("warning", f"{trait.trouble}: {enumerated(named)}. {trait.meaning}")


OF_ALL: dict[str, Check] = {
    "completeness": _completeness,
    "failures": _failures,
    "repeatability": _repeatability,
    **{name: partial(_trait, name) for name in TRAITS},
}
