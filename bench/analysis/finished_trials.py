"""Check the finished trials of a study: values, budgets, traces, points, seeds and times."""

from __future__ import annotations

import numpy as np

from bench.analysis.cells import scores, stopped_early
from bench.analysis.evidence import (
    CELL,
    Check,
    Evidence,
    Finding,
    cell_names,
    enumerated,
    floats,
    judge,
    on_bound,
    percentages,
)
from bench.analysis.timing import CONTENTION, HIDDEN_THREADS
from bench.analysis.traits import percent

UNUSED = 0.01  # share of the budget that may be left without a reason
UNIQUE = 0.5  # share of different final values below which a cell has hit a ceiling
CLAMPED = 0.01  # share of final coordinates that may lie on a bound

NO_TRACES = Finding("not checked", "The traces are unknown here.")
NO_POINTS = Finding("not checked", "The final points are unknown here.")


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
