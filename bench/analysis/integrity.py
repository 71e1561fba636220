"""Check a study's own records for the known traps of benchmarking.

The traits of an optimizer that leave no sign in the results of a study need runs of their own: ``bench check`` makes
them and records what it finds in the study's folder.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from bench.analysis.cells import Traces, coverage, scores, stopped_early
from bench.analysis.evidence import (
    CELL,
    Boxes,
    Diagnoses,
    Evidence,
    Finding,
    cell_names,
    enumerated,
    floats,
    judge,
    on_bound,
    percentages,
    where,
)
from bench.analysis.timing import CONTENTION, HIDDEN_THREADS
from bench.analysis.traits import TRAITS, percent

UNUSED = 0.01  # share of the budget that may be left without a reason
UNIQUE = 0.5  # share of different final values below which a cell has hit a ceiling
CLAMPED = 0.01  # share of final coordinates that may lie on a bound

NO_TRACES = Finding("not checked", "The traces are unknown here.")
NO_POINTS = Finding("not checked", "The final points are unknown here.")

Check = Callable[[Evidence], Finding]


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


def _finite(evidence: Evidence) -> Finding:
    return judge(
        evidence.finished,
        ~np.isfinite(floats(evidence.finished, "fun")),
        "warning",
        "ended without a finite value",
        "They count as +inf.",
        well="Every finished trial ended with a finite value.",
    )


def _budget(evidence: Evidence) -> Finding:
    return judge(
        evidence.finished,
        floats(evidence.finished, "nfev") > evidence.budget,
        "error",
        f"record more evaluations than the budget of {evidence.budget:,}",
        "The harness prevents this, so the results were changed.",
        well=f"No trial made more than the {evidence.budget:,} evaluations of the budget.",
    )


def _records(evidence: Evidence) -> Finding:
    if not evidence.traces:
        return NO_TRACES
    finished = evidence.finished
    traces = evidence.traces_of(finished)
    value = np.array([trace.values[-1] if len(trace.values) else np.inf for trace in traces])
    evaluation = np.array([trace.evaluations[-1] if len(trace.values) else 0 for trace in traces])
    found = floats(finished, "fun")
    return judge(
        finished,
        (np.isfinite(found) & (found != value)) | (evaluation > floats(finished, "nfev")),
        "error",
        "have no trace, or one that ends at another value or after more evaluations",
        "The results were changed.",
        well="Every final value and number of evaluations agrees with the trace of its trial.",
    )


def _undeclared_stops(evidence: Evidence) -> Finding:
    early = floats(evidence.finished, "nfev") < (1 - UNUSED) * evidence.budget
    return judge(
        evidence.finished,
        early & ~stopped_early(evidence.finished).to_numpy(),
        "warning",
        f"left more than {percent(UNUSED)} of the budget unused without a declared reason",
        well=f"Every trial used at least {percent(1 - UNUSED)} of its budget or declared why it stopped.",
    )


def _declared_stops(evidence: Evidence) -> Finding:
    declared = stopped_early(evidence.finished).to_numpy()
    stops = evidence.finished.loc[declared, "optimizer"] + ": " + evidence.finished.loc[declared, "stop"]
    return judge(
        evidence.finished,
        declared,
        "note",
        "ended by a stopping criterion of the optimizer",
        f"Reasons: {enumerated([f'{stop} ({count:,})' for stop, count in stops.value_counts().items()])}.",
        well="No trial ended by a stopping criterion of the optimizer.",
    )


def _outside_box(evidence: Evidence) -> Finding:
    outside = floats(evidence.finished, "outside_box")
    sums = evidence.finished.assign(outside=outside).groupby("optimizer", sort=False)[["outside", "nfev"]].sum()
    share = (sums["outside"] / sums["nfev"])[sums["outside"] > 0]
    return judge(
        evidence.finished,
        outside > 0,
        "note",
        "evaluated points outside the box, which count against the budget",
        f"Shares of the evaluations: {percentages(share)}.",
        well="Every evaluation lay inside the box.",
    )


def _repeated_points(evidence: Evidence) -> Finding:
    if not evidence.variables:
        return NO_POINTS
    once = evidence.finished.drop_duplicates([*CELL, "seed"])  # equal seeds are another check's finding
    return judge(
        once,
        once.duplicated([*CELL, *evidence.variables], keep=False).to_numpy(),
        "error",
        "ended at exactly the same point as a trial of the same cell with another seed",
        "Two trials meet by chance only in a corner of the box.",
        well="No two trials of a cell ended at the same point.",
    )


def _ceiling(evidence: Evidence) -> Finding:
    finals = evidence.finished[np.isfinite(floats(evidence.finished, "fun"))]
    if finals.empty:
        return Finding("not checked", "No trial ended with a finite value.")
    cells = finals.assign(fun=scores(finals, merge=True)).groupby(CELL, sort=False)["fun"]
    share = cells.transform("nunique") / cells.transform("size")
    return judge(
        finals,
        (share < UNIQUE).to_numpy(),
        "warning",
        f"belong to cells where fewer than {percent(UNIQUE)} of the final values differ by more than rounding",
        "Such cells have hit a ceiling, and their trials cannot be distinguished.",
        well=f"In every cell at least {percent(UNIQUE)} of the final values differ.",
    )


def _same_algorithm(evidence: Evidence) -> Finding:
    if not evidence.variables:
        return NO_POINTS
    if not evidence.traces:
        return NO_TRACES
    finished, place = evidence.finished, ["problem", *evidence.variables]
    same = finished[finished.duplicated(place, keep=False)]
    traces = evidence.traces_of(same)
    same = same.assign(
        found=[trace.values.tobytes() for trace in traces], when=[trace.evaluations.tobytes() for trace in traces]
    )
    optimizers = same.groupby([*place, "found", "when"], sort=False, dropna=False)["optimizer"].transform("nunique")
    return judge(
        finished,
        finished.index.isin(same.index[optimizers > 1]),
        "warning",
        "equal a trial of another optimizer in point and trace",
        "An algorithm may be compared with itself.",
        well="No trial equals a trial of another optimizer in point and trace.",
    )


def _clamping(evidence: Evidence) -> Finding:
    bound = on_bound(evidence.finished, evidence.boxes)
    if not bound.notna().to_numpy().any():
        return Finding("not checked", "The boxes of the problems are unknown here.")
    by_optimizer = bound.groupby(evidence.finished["optimizer"], sort=False)
    share = by_optimizer.sum().sum(axis=1) / by_optimizer.count().sum(axis=1)
    high = share[share > CLAMPED]
    unknown = sorted(set(evidence.finished["problem"]) - set(evidence.boxes))
    rest = f" The box is unknown for {enumerated(unknown)}." if unknown else ""
    if high.empty:
        text = (
            f"At most {percent(share.max())} of the final coordinates of any optimizer lie on a bound of the box.{rest}"
        )
        return Finding("pass", text)
    worst = {name: percentages(each[each > 0].nlargest(2)) for name, each in by_optimizer.mean().T.items()}
    named = [f"{name} {percent(value)} ({worst[name]})" for name, value in high.items()]
    clamped = evidence.finished["optimizer"].isin(high.index) & (bound.sum(axis=1) > 0)
    return Finding(
        "warning",
        f"Final coordinates on a bound of the box: {enumerated(named)}. The optimum may lie there, or a repair may "
        f"move points there.{rest}",
        cell_names(evidence.finished[clamped]),
    )


def _seeds(evidence: Evidence) -> Finding:
    known = evidence.finished[evidence.finished["seed"].notna()]
    own = known.duplicated(["optimizer", "seed"], keep=False).to_numpy()
    return judge(
        known,
        own if own.any() else known.duplicated("seed", keep=False).to_numpy(),
        "error" if own.any() else "warning",
        f"share their seed with a trial of {'the same' if own.any() else 'another'} optimizer",
        "Such trials are not independent; run one of the optimizers or versions with another study seed.",
        well=f"All {len(known):,} seeds differ.",
    )


def _random_streams(evidence: Evidence) -> Finding:
    if not evidence.traces:
        return NO_TRACES
    traces = evidence.traces_of(evidence.finished)
    starts = evidence.finished.assign(first=[trace.values[0] if len(trace.values) else np.nan for trace in traces])
    starts = starts[starts["first"].notna()]
    # Trials of one optimizer that all start at one point, or on a plateau, do not show its random stream.
    varied = starts.groupby(CELL)["first"].transform("nunique") > 1
    drawn = starts[varied & ~starts.duplicated([*CELL, "first"], keep=False)]
    return judge(
        evidence.finished,
        evidence.finished.index.isin(drawn.index[drawn.duplicated(["problem", "trial", "first"], keep=False)]),
        "warning",
        "start at exactly the same value as the same trial of another optimizer",
        "The optimizers may share a random stream.",
        well="No two optimizers start a trial at the same value.",
    )


def _contention(evidence: Evidence) -> Finding:
    return _disturbed(
        evidence,
        "contention",
        f"Trials waited for a core (median wall time above {CONTENTION:g} times CPU time)",
        well=f"Median wall time is at most {CONTENTION:g} times CPU time.",
    )


def _hidden_threads(evidence: Evidence) -> Finding:
    return _disturbed(
        evidence,
        "hidden_threads",
        f"Trials used more than one core (median CPU time above {HIDDEN_THREADS:g} times wall time)",
        well=f"Median CPU time is at most {HIDDEN_THREADS:g} times wall time.",
    )


def _disturbed(evidence: Evidence, flag: str, trouble: str, *, well: str) -> Finding:
    table = evidence.times
    if not table["wall_per_cpu"].notna().any():
        return Finding("not checked", "No processor time was measured.")
    disturbed = table[table[flag]]
    ratios = [f"{name} {ratio:.2f}" for name, ratio in disturbed[["optimizer", "wall_per_cpu"]].to_numpy()]
    return Finding("warning", f"{trouble}; wall/CPU: {enumerated(ratios)}.") if ratios else Finding("pass", well)


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
OF_FINISHED: dict[str, Check] = {
    "finite values": _finite,
    "budget": _budget,
    "records": _records,
    "undeclared stops": _undeclared_stops,
    "declared stops": _declared_stops,
    "outside the box": _outside_box,
    "repeated points": _repeated_points,
    "ceiling": _ceiling,
    "same algorithm": _same_algorithm,
    "clamping": _clamping,
    "seeds": _seeds,
    "random streams": _random_streams,
    "contention": _contention,
    "hidden threads": _hidden_threads,
}
