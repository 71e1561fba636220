"""Whether the results can be trusted: checks of a study's own records for the known traps of benchmarking.

What an optimizer favours by itself leaves no sign in the results of a study: it needs runs of its own, which
``bench check`` makes and notes in the study's folder.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, Literal, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.analysis.cells import Traces, coverage, scores, stopped_early, variables
from bench.analysis.timing import CONTENTION, HIDDEN_THREADS, timing
from bench.analysis.traits import TRAITS, percent
from bench.objective import Trace
from bench.problem import Floats

UNUSED = 0.01  # share of the budget that may be left without a reason
UNIQUE = 0.5  # share of different final values below which a cell has hit a ceiling
CLAMPED = 0.01  # share of final coordinates that may lie on a bound
ON_BOUND = 1e-12  # of the box's width: a clipped point that is scaled back is rounded
NAMED = 5  # names in a sentence; the column ``cells`` holds all

Verdict = Literal["pass", "note", "warning", "error", "not checked"]
Boxes = Mapping[str, Mapping[str, tuple[float, float]]]
Diagnoses = Mapping[str, Sequence[Mapping[str, Any]]]
CELL = ["problem", "optimizer"]


class Finding(NamedTuple):
    """What one check says: its verdict, one or two short sentences, and the cells concerned."""

    verdict: Verdict
    text: str
    cells: Sequence[str] = ()


NO_TRACES = Finding("not checked", "The traces are not known here.")
NO_POINTS = Finding("not checked", "The final points are not known here.")
EMPTY = Trace(np.empty(0, dtype=np.int64), np.empty(0))


@dataclass(frozen=True)
class Evidence:
    """What the checks look at; see :func:`integrity`."""

    frame: pd.DataFrame
    budget: int
    planned: int
    traces: Traces
    boxes: Boxes
    diagnoses: Diagnoses
    verifications: Sequence[Mapping[str, Any]]

    @cached_property
    def finished(self) -> pd.DataFrame:
        """The trials that did not fail, problem and optimizer as plain labels."""
        finished = self.frame[self.frame["status"] == "ok"]
        return finished.astype(dict.fromkeys(CELL, object)).reset_index(drop=True)

    @property
    def variables(self) -> list[str]:
        """The columns of the final points."""
        return variables(self.frame)

    @cached_property
    def times(self) -> pd.DataFrame:
        """What trials take, by optimizer."""
        return timing(self.frame)

    def traces_of(self, trials: pd.DataFrame) -> list[Trace]:
        """Return the trace of each of the trials, an empty one where there is none."""
        keys = zip(trials["problem"], trials["optimizer"], trials["trial"], strict=True)
        return [self.traces.get(key, EMPTY) for key in keys]


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
    hold), "error" (trials are lost, not independent or not what the harness wrote) or "not checked" (no trial to
    look at, or no ``traces``, ``boxes``, ``diagnoses`` or ``verifications``). The ``finding`` says why in words,
    ``cells`` names every "optimizer on problem" concerned, separated by semicolons.

    Args:
        frame: the tidy frame.
        study_budget: evaluations that each trial was allowed.
        planned_trials: trials that each cell should hold.
        traces: by (problem, optimizer, trial).
        boxes: the lower and upper bound of each variable, by problem and by variable.
        diagnoses: what ``bench check`` found of each optimizer, by label: check, passed and, where there is one,
            figure.
        verifications: what ``bench verify`` noted in each folder
            (:meth:`bench.storage.folder.Folder.verification`), empty where it did not.
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
        return Finding("warning", "There is no trial at all.")
    if not missing.any() and stored.nunique() == 1:
        return Finding("pass", f"All planned trials are stored: {stored.sum():,}, {stored.max():,} in each cell.")
    short = table[stored < stored.max()]
    text = (
        f"{missing.sum():,} of {evidence.planned * len(table):,} planned trials are missing and "
        f"{(stored == 0).sum():,} of {len(table):,} cells are empty."
    )
    if not short.empty:
        text += f" Cells hold {stored.min():,} to {stored.max():,} trials; fewer than others: {_where(short)}."
    return Finding("warning", text, _cells(table[(missing > 0) | (stored < stored.max())]))


def _failures(evidence: Evidence) -> Finding:
    total = len(evidence.frame)
    if not total:
        return Finding("not checked", "There is no trial.")
    status = evidence.frame["status"]
    kinds = status[status != "ok"].value_counts()
    return _verdict(
        evidence.frame,
        (status != "ok").to_numpy(),
        "error",
        f"did not finish ({_few([f'{kind} {count:,}' for kind, count in kinds.items()])})",
        "They count as +inf.",
        well=f"All {total:,} trials finished.",
    )


def _repeatability(evidence: Evidence) -> Finding:
    if not evidence.verifications or not all(evidence.verifications):
        return Finding("not checked", "Run 'bench verify' with this folder to have trials of each cell made again.")
    different = [str(line) for noted in evidence.verifications for line in noted.get("different") or ()]
    said = "; ".join(str(noted.get("sentence")) for noted in evidence.verifications)
    if different:
        return Finding("error", f"{said}. Not repeated: {_few(different)}. Results depend on more than their seeds.")
    return Finding("pass", f"Made again, {said}.")


def _finite(evidence: Evidence) -> Finding:
    return _verdict(
        evidence.finished,
        ~np.isfinite(_floats(evidence.finished, "fun")),
        "warning",
        "ended without a finite value",
        "They count as +inf.",
        well="Every finished trial ended with a finite value.",
    )


def _budget(evidence: Evidence) -> Finding:
    return _verdict(
        evidence.finished,
        _floats(evidence.finished, "nfev") > evidence.budget,
        "error",
        f"claim more evaluations than the budget of {evidence.budget:,}",
        "The harness allows none, so the results were changed.",
        well=f"No trial made more than the {evidence.budget:,} evaluations of the budget.",
    )


def _records(evidence: Evidence) -> Finding:
    if not evidence.traces:
        return NO_TRACES
    finished = evidence.finished
    traces = evidence.traces_of(finished)
    value = np.array([trace.values[-1] if len(trace.values) else np.inf for trace in traces])
    evaluation = np.array([trace.evaluations[-1] if len(trace.values) else 0 for trace in traces])
    found = _floats(finished, "fun")
    return _verdict(
        finished,
        (np.isfinite(found) & (found != value)) | (evaluation > _floats(finished, "nfev")),
        "error",
        "have no trace, or one that ends at another value or after more evaluations",
        "The results were changed.",
        well="Every final value and number of evaluations agrees with the trial’s trace.",
    )


def _undeclared_stops(evidence: Evidence) -> Finding:
    early = _floats(evidence.finished, "nfev") < (1 - UNUSED) * evidence.budget
    return _verdict(
        evidence.finished,
        early & ~stopped_early(evidence.finished).to_numpy(),
        "warning",
        f"left more than {percent(UNUSED)} of the budget unused without a declared reason",
        well=f"Every trial used at least {percent(1 - UNUSED)} of its budget or declared why it stopped.",
    )


def _declared_stops(evidence: Evidence) -> Finding:
    declared = stopped_early(evidence.finished).to_numpy()
    stops = evidence.finished.loc[declared, "optimizer"] + ": " + evidence.finished.loc[declared, "stop"]
    return _verdict(
        evidence.finished,
        declared,
        "note",
        "ended by a criterion of their own",
        f"Reasons: {_few([f'{stop} ({count:,})' for stop, count in stops.value_counts().items()])}.",
        well="No trial ended by a criterion of its own.",
    )


def _outside_box(evidence: Evidence) -> Finding:
    outside = _floats(evidence.finished, "outside_box")
    sums = evidence.finished.assign(outside=outside).groupby("optimizer", sort=False)[["outside", "nfev"]].sum()
    share = (sums["outside"] / sums["nfev"])[sums["outside"] > 0]
    return _verdict(
        evidence.finished,
        outside > 0,
        "note",
        "evaluated points outside the box, at the cost of their budget",
        f"Shares of the evaluations: {_shares(share)}.",
        well="Every evaluation lay inside the box.",
    )


def _repeated_points(evidence: Evidence) -> Finding:
    if not evidence.variables:
        return NO_POINTS
    once = evidence.finished.drop_duplicates([*CELL, "seed"])  # equal seeds are another check's finding
    return _verdict(
        once,
        once.duplicated([*CELL, *evidence.variables], keep=False).to_numpy(),
        "error",
        "ended at exactly the same point as another of their cell, in spite of another seed",
        "Only a corner of the box is met twice by chance.",
        well="No two trials of a cell ended at the same point.",
    )


def _ceiling(evidence: Evidence) -> Finding:
    finals = evidence.finished[np.isfinite(_floats(evidence.finished, "fun"))]
    if finals.empty:
        return Finding("not checked", "No trial ended with a finite value.")
    cells = finals.assign(fun=scores(finals, merge=True)).groupby(CELL, sort=False)["fun"]
    share = cells.transform("nunique") / cells.transform("size")
    return _verdict(
        finals,
        (share < UNIQUE).to_numpy(),
        "warning",
        f"belong to cells where fewer than {percent(UNIQUE)} of the final values differ by more than rounding",
        "Trials that meet a ceiling cannot be told apart.",
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
    return _verdict(
        finished,
        finished.index.isin(same.index[optimizers > 1]),
        "warning",
        "are one of another optimizer as well, point and trace",
        "One algorithm may be compared with itself.",
        well="No trial is the same, point and trace, as one of another optimizer.",
    )


def _clamping(evidence: Evidence) -> Finding:
    on_bound = _on_bound(evidence.finished, evidence.boxes)
    if not on_bound.notna().to_numpy().any():
        return Finding("not checked", "The boxes of the problems are not known here.")
    by_optimizer = on_bound.groupby(evidence.finished["optimizer"], sort=False)
    share = by_optimizer.sum().sum(axis=1) / by_optimizer.count().sum(axis=1)
    high = share[share > CLAMPED]
    unknown = sorted(set(evidence.finished["problem"]) - set(evidence.boxes))
    rest = f" The box is not known of {_few(unknown)}." if unknown else ""
    if high.empty:
        text = f"At most {percent(share.max())} of an optimizer’s final coordinates lie on a bound of the box.{rest}"
        return Finding("pass", text)
    worst = {name: _shares(each[each > 0].nlargest(2)) for name, each in by_optimizer.mean().T.items()}
    named = [f"{name} {percent(value)} ({worst[name]})" for name, value in high.items()]
    clamped = evidence.finished["optimizer"].isin(high.index) & (on_bound.sum(axis=1) > 0)
    return Finding(
        "warning",
        f"Final coordinates on a bound of the box: {_few(named)}. The optimum may lie there, or a repair moves points "
        f"there.{rest}",
        _cells(evidence.finished[clamped]),
    )


def _on_bound(trials: pd.DataFrame, boxes: Boxes) -> pd.DataFrame:
    """Return 1 or 0 for each trial and variable, NaN where the trial's problem has no such variable or no known box."""
    table = pd.DataFrame(index=trials.index)
    for name in dict.fromkeys(name for box in boxes.values() for name in box):
        if f"x_{name}" in trials:
            ends = [boxes.get(problem, {}).get(name, (np.nan, np.nan)) for problem in trials["problem"]]
            lower, upper = np.array(ends, dtype=float).T
            x, near = _floats(trials, f"x_{name}"), ON_BOUND * (upper - lower)
            table[name] = np.where(np.isnan(x - lower), np.nan, (x <= lower + near) | (x >= upper - near))
    return table


def _seeds(evidence: Evidence) -> Finding:
    known = evidence.finished[evidence.finished["seed"].notna()]
    own = known.duplicated(["optimizer", "seed"], keep=False).to_numpy()
    return _verdict(
        known,
        own if own.any() else known.duplicated("seed", keep=False).to_numpy(),
        "error" if own.any() else "warning",
        f"share their seed with one of {'the same' if own.any() else 'another'} optimizer",
        "Such trials are not independent; run one of the optimizers or versions with another study seed.",
        well=f"All {len(known):,} seeds differ.",
    )


def _random_streams(evidence: Evidence) -> Finding:
    if not evidence.traces:
        return NO_TRACES
    traces = evidence.traces_of(evidence.finished)
    starts = evidence.finished.assign(first=[trace.values[0] if len(trace.values) else np.nan for trace in traces])
    starts = starts[starts["first"].notna()]
    # Trials of one optimizer that all start at one point, or a plateau, say nothing of its random stream.
    varied = starts.groupby(CELL)["first"].transform("nunique") > 1
    drawn = starts[varied & ~starts.duplicated([*CELL, "first"], keep=False)]
    return _verdict(
        evidence.finished,
        evidence.finished.index.isin(drawn.index[drawn.duplicated(["problem", "trial", "first"], keep=False)]),
        "warning",
        "start at exactly the value of the same trial of another optimizer",
        "Optimizers may share a random stream.",
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
    return Finding("warning", f"{trouble}; wall/CPU: {_few(ratios)}.") if ratios else Finding("pass", well)


def _trait(name: str, evidence: Evidence) -> Finding:
    """Say which optimizers have a trait that ``bench check`` looks for."""
    trait = TRAITS[name]
    found = [(label, each) for label, those in evidence.diagnoses.items() for each in those if each["check"] == name]
    if not found:
        return Finding("not checked", "Run 'bench check' with this folder to have the optimizers checked for it.")
    figures = [(label, each.get("figure")) for label, each in found if not each["passed"]]
    if not figures:
        return Finding("pass", f"None of {len(found):,} optimizers {trait.well}.")
    named = [label if figure is None else f"{label} {trait.figure(figure)}" for label, figure in figures]
    return Finding("warning", f"{trait.trouble}: {_few(named)}. {trait.meaning}")


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


def _verdict(
    trials: pd.DataFrame, bad: NDArray[np.bool_], verdict: Verdict, did: str, meaning: str = "", *, well: str
) -> Finding:
    """Return what the ``bad`` trials ``did``, where, and its ``meaning``; a pass that says ``well`` if none is bad."""
    if not bad.any():
        return Finding("pass", well)
    text = f"{bad.sum():,} of {len(trials):,} trials {did}, in {_where(trials[bad])}. {meaning}"
    return Finding(verdict, text.strip(), _cells(trials[bad]))


def _cells(rows: pd.DataFrame) -> list[str]:
    """Return the cells of the rows, each as "optimizer on problem"."""
    pairs = rows[["optimizer", "problem"]].astype(object).drop_duplicates()
    return [f"{optimizer} on {problem}" for optimizer, problem in pairs.to_numpy()]


def _where(rows: pd.DataFrame) -> str:
    """Return the same in short: "a on p, b on 18 problems"."""
    problems = rows.astype(dict.fromkeys(CELL, object)).groupby("optimizer", sort=False)["problem"].unique()
    return _few([f"{o} on {each[0] if len(each) == 1 else f'{len(each):,} problems'}" for o, each in problems.items()])


def _floats(trials: pd.DataFrame, column: str) -> Floats:
    return pd.to_numeric(trials[column], errors="coerce").to_numpy(dtype=float)


def _few(names: Sequence[str]) -> str:
    more = len(names) - NAMED
    return ", ".join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")


def _shares(shares: pd.Series[float]) -> str:
    return _few([f"{name} {percent(share)}" for name, share in shares.items()])
