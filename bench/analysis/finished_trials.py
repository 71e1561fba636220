"""Check the finished trials of a study: values, budgets, traces, points, seeds and times."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Literal, NamedTuple

import numpy as np
import pandas as pd

from bench.analysis.cells import (
    BEATEN,
    CELL,
    CONTENTION,
    HIDDEN_THREADS,
    Budgets,
    Traces,
    budgets,
    scores,
    stopped_early,
    timing,
    traces_of,
    variables,
)
from bench.helpers.text import listed

UNUSED = 0.01  # share of the budget that may be left without a reason
UNIQUE = 0.5  # share of different final values below which a cell has mostly ties
CLAMPED = 0.01  # share of final coordinates that may lie on a bound
SHARED = 0.1  # of an optimizer's trials, above which equal starts are no chance
ON_BOUND = 1e-12  # of the box's width: a clipped point that is scaled back is rounded

CLAMPING = "boundary clamping"  # of final points here, and of an optimizer in the runs of ``bench check``

Verdict = Literal["pass", "warning", "error", "not checked"]
Boxes = Mapping[str, Mapping[str, tuple[float, float]]]
NUMBERS = ["fun", "nfev"]


class CheckResult(NamedTuple):
    """The result of one check: its verdict, one or two short sentences, and the cells concerned."""

    verdict: Verdict
    text: str
    cells: Sequence[str] = ()


NO_TRACES = CheckResult("not checked", "The traces are unknown here.")
NO_POINTS = CheckResult("not checked", "The final points are unknown here.")


@dataclass(frozen=True)
class Evidence:
    """The trials that the checks look at and what is known about them; see :func:`bench.analysis.integrity`."""

    frame: pd.DataFrame
    budget: Budgets  # of every trial, or by problem, or by (problem, optimizer)
    traces: Traces
    boxes: Boxes
    optima: Mapping[str, float]  # by problem, where they are known

    @property
    def allowed(self) -> str:
        """The budget in words."""
        return "its budget allows" if isinstance(self.budget, Mapping) else f"the budget of {self.budget:,}"

    @cached_property
    def finished(self) -> pd.DataFrame:
        """The trials that finished: plain labels, numbers as float64, and those of each trace.

        These are its ``first`` and ``last`` value, missing without a trace, and the evaluation that found the last one.
        """
        finished = self.frame[self.frame["status"] == "ok"]
        finished = finished.astype(dict.fromkeys(CELL, object)).reset_index(drop=True)
        numbers = finished[NUMBERS].apply(pd.to_numeric, errors="coerce").astype(float)
        ends = np.full((len(finished), 3), np.nan)
        for place, trace in enumerate(traces_of(finished, self.traces)):
            if len(trace.values):
                ends[place] = trace.values[0], trace.values[-1], trace.evaluations[-1]
        return finished.assign(**numbers, **dict(zip(("first", "last", "last_at"), ends.T, strict=True)))


def judge(
    trials: pd.DataFrame, bad: pd.Series[bool], verdict: Verdict, did: str, meaning: str = "", *, well: str
) -> CheckResult:
    """Return the finding on the ``bad`` trials: what they ``did``, their cells, its meaning; a pass if none is bad."""
    if not bad.any():
        return CheckResult("pass", well)
    text = f"{bad.sum():,} of {len(trials):,} trials {did}, in {where(trials[bad])}. {meaning}"
    return CheckResult(verdict, text.strip(), cell_names(trials[bad]))


def cell_names(rows: pd.DataFrame) -> list[str]:
    """Return the cells of the rows, each as "optimizer on problem"."""
    pairs = rows[["optimizer", "problem"]].astype(object).drop_duplicates()
    return [f"{optimizer} on {problem}" for optimizer, problem in pairs.to_numpy()]


def where(rows: pd.DataFrame) -> str:
    """Return the cells of the rows in short: "a on p, b on 18 problems, c on 25 instances of 5 problems"."""
    by_optimizer = rows.astype(dict.fromkeys(CELL, object)).groupby("optimizer", sort=False)
    return listed([f"{optimizer} on {_problems(of_optimizer)}" for optimizer, of_optimizer in by_optimizer])


def _problems(rows: pd.DataFrame) -> str:
    """Return the problem of the rows, or how many there are, in the units in which the study counts them."""
    problems = rows["problem"].unique()
    pools = rows["pool"].astype(object).unique() if "pool" in rows else problems
    if len(problems) == 1:
        return str(problems[0])
    if len(pools) == len(problems):
        return f"{len(problems):,} problems"
    return f"{len(problems):,} instances of {pools[0] if len(pools) == 1 else f'{len(pools):,} problems'}"


def percent(share: float) -> str:
    """Return a share as a percentage of three digits."""
    return f"{100 * share:.3g}%"


def _percentages(shares: pd.Series[float]) -> str:
    """Return shares as "a 1%, b 2.5%"."""
    return listed([f"{name} {percent(share)}" for name, share in shares.items()])


def _finite(evidence: Evidence) -> CheckResult:
    return judge(
        evidence.finished,
        ~np.isfinite(evidence.finished["fun"]),
        "warning",
        "ended without a finite value",
        "They count as +inf.",
        well="Every finished trial ended with a finite value.",
    )


def _budget(evidence: Evidence) -> CheckResult:
    return judge(
        evidence.finished,
        evidence.finished["nfev"] > budgets(evidence.finished, evidence.budget),
        "error",
        f"record more evaluations than {evidence.allowed}",
        "The harness prevents this, so the results were changed.",
        well=f"No trial made more evaluations than {evidence.allowed}.",
    )


def _records(evidence: Evidence) -> CheckResult:
    if not evidence.traces:
        return NO_TRACES
    trials = evidence.finished
    return judge(
        trials,
        (np.isfinite(trials["fun"]) & (trials["fun"] != trials["last"])) | (trials["last_at"] > trials["nfev"]),
        "error",
        "have no trace, or one that ends at another value or after more evaluations",
        "The results were changed.",
        well="Every final value and number of evaluations agrees with the trace of its trial.",
    )


def _undeclared_stops(evidence: Evidence) -> CheckResult:
    trials = evidence.finished[evidence.finished["stop"].notna()]
    if trials.empty:
        return CheckResult("not checked", "Imported results do not say why a trial stopped.")
    return judge(
        trials,
        (trials["nfev"] < (1 - UNUSED) * budgets(trials, evidence.budget)) & ~stopped_early(trials),
        "warning",
        f"left more than {percent(UNUSED)} of the budget unused without a declared reason",
        well=f"Every trial used at least {percent(1 - UNUSED)} of its budget or declared why it stopped.",
    )


def _repeated_points(evidence: Evidence) -> CheckResult:
    once = evidence.finished.drop_duplicates([*CELL, "seed"])  # equal seeds are another check's finding
    point = variables(once)
    if not point:
        return NO_POINTS
    return judge(
        once,
        once.duplicated([*CELL, *point], keep=False),
        "error",
        "ended at exactly the same point as a trial of the same cell with another seed",
        "Two trials meet by chance only in a corner of the box.",
        well="No two trials of a cell ended at the same point.",
    )


def _ties(evidence: Evidence) -> CheckResult:
    finals = evidence.finished[np.isfinite(evidence.finished["fun"])]
    if finals.empty:
        return CheckResult("not checked", "No trial ended with a finite value.")
    cells = finals.assign(fun=scores(finals, merge=True)).groupby(CELL, sort=False)["fun"]
    return judge(
        finals,
        cells.transform("nunique") / cells.transform("size") < UNIQUE,
        "warning",
        "end at few different values",
        f"Fewer than {percent(UNIQUE)} of the final values of such a cell differ by more than rounding; in every "
        "comparison a tie counts half.",
        well=f"In every cell at least {percent(UNIQUE)} of the final values differ.",
    )


def _below_optimum(evidence: Evidence) -> CheckResult:
    if not evidence.optima:
        return CheckResult("not checked", "The optima of the problems are unknown here.")
    optimum = evidence.finished["problem"].map(evidence.optima).astype(float)
    return judge(
        evidence.finished,
        evidence.finished["fun"] < optimum - BEATEN * optimum.abs().clip(lower=1),
        "warning",
        "ended below the known optimum",
        "That value or the optimum is wrong.",
        well="No trial ended below a known optimum.",
    )


def _same_algorithm(evidence: Evidence) -> CheckResult:
    trials, point = evidence.finished, variables(evidence.finished)
    if not point:
        return NO_POINTS
    if not evidence.traces:
        return NO_TRACES
    same = trials[trials.duplicated(["problem", *point], keep=False)]
    same = same.assign(course=[trace.packed() for trace in traces_of(same, evidence.traces)])
    equal = same.groupby(["problem", *point, "course"], sort=False, dropna=False)
    optimizers = equal["optimizer"].transform("nunique")
    return judge(
        trials,
        trials.index.to_series().isin(same.index[optimizers > 1]),
        "warning",
        "equal a trial of another optimizer in point and trace",
        "An algorithm may be compared with itself.",
        well="No trial equals a trial of another optimizer in point and trace.",
    )


def _clamping(evidence: Evidence) -> CheckResult:
    trials, bound = evidence.finished, _on_bound(evidence.finished, evidence.boxes)
    if not bound.notna().to_numpy().any():
        return CheckResult("not checked", "The boxes of the problems are unknown here.")
    by_optimizer = bound.groupby(trials["optimizer"], sort=False)
    share = by_optimizer.sum().sum(axis=1) / by_optimizer.count().sum(axis=1)
    high = share[share > CLAMPED]
    unknown = sorted(set(trials["problem"]) - set(evidence.boxes))
    unknown_boxes = f" The box is unknown for {listed(unknown)}." if unknown else ""
    if high.empty:
        least = f"At most {percent(share.max())} of the final coordinates of any optimizer lie on a bound of the box."
        return CheckResult("pass", least + unknown_boxes)
    worst = {name: _percentages(shares[shares > 0].nlargest(2)) for name, shares in by_optimizer.mean().T.items()}
    named = [f"{name} {percent(value)} ({worst[name]})" for name, value in high.items()]
    return CheckResult(
        "warning",
        f"Final coordinates on a bound of the box: {listed(named)}. The optimum may lie there, or a repair may "
        f"move points there.{unknown_boxes}",
        cell_names(trials[trials["optimizer"].isin(high.index) & (bound.sum(axis=1) > 0)]),
    )


def _on_bound(trials: pd.DataFrame, boxes: Boxes) -> pd.DataFrame:
    """Return 1 or 0 for each trial and variable, NaN where the trial's problem has no such variable or no known box."""
    table = pd.DataFrame(index=trials.index)
    for name in dict.fromkeys(name for box in boxes.values() for name in box):
        if f"x_{name}" in trials:
            ends = [boxes.get(problem, {}).get(name, (np.nan, np.nan)) for problem in trials["problem"]]
            lower, upper = np.array(ends, dtype=float).T
            x, near = pd.to_numeric(trials[f"x_{name}"], errors="coerce"), ON_BOUND * (upper - lower)
            table[name] = ((x <= lower + near) | (x >= upper - near)).astype(float).where((x - lower).notna())
    return table


def _seeds(evidence: Evidence) -> CheckResult:
    seeded = evidence.finished[evidence.finished["seed"].notna()]
    if seeded.empty:
        return CheckResult("not checked", "The seeds are unknown here, as of imported results.")
    within = seeded.duplicated(["optimizer", "seed"], keep=False)
    return judge(
        seeded,
        within if within.any() else seeded.duplicated("seed", keep=False),
        "error" if within.any() else "warning",
        f"share their seed with a trial of {'the same' if within.any() else 'another'} optimizer",
        "Such trials are not independent; run one of the optimizers or versions with another study seed.",
        well=f"All {len(seeded):,} seeds differ.",
    )


def _random_streams(evidence: Evidence) -> CheckResult:
    if not evidence.traces:
        return NO_TRACES
    trials = evidence.finished
    starts = trials[trials["first"].notna()]
    # Trials of one optimizer that all start at one point, or on a plateau, do not show its random stream.
    varied = starts.groupby(CELL)["first"].transform("nunique") > 1
    drawn = starts[varied & ~starts.duplicated([*CELL, "first"], keep=False)]
    equal = drawn.duplicated(["problem", "trial", "first"], keep=False)
    # Two trials may meet by chance on a plateau, as in a step function; a shared stream shows in most trials.
    often = equal.groupby(drawn["optimizer"]).transform("mean") > SHARED
    return judge(
        trials,
        trials.index.to_series().isin(drawn.index[equal & often]),
        "warning",
        "start at exactly the same value as the same trial of another optimizer",
        "The optimizers may share a random stream.",
        well="No two optimizers start a trial at the same value.",
    )


def _disturbed(flag: str, trouble: str, limit: str, evidence: Evidence) -> CheckResult:
    """Return the optimizers that have a ``flag`` of :func:`bench.analysis.timing`."""
    table = timing(evidence.frame)
    if not table["wall_per_cpu"].notna().any():
        return CheckResult("not checked", "No processor time was measured.")
    ratios = [f"{name} {ratio:.2f}" for name, ratio in table.loc[table[flag], ["optimizer", "wall_per_cpu"]].to_numpy()]
    if not ratios:
        return CheckResult("pass", f"Median {limit.format('is at most')}.")
    return CheckResult("warning", f"{trouble} (median {limit.format('above')}); wall/CPU: {listed(ratios)}.")


WAITED = f"wall time {{}} {CONTENTION:g} times CPU time"
THREADED = f"CPU time {{}} {HIDDEN_THREADS:g} times wall time"

CHECKS: dict[str, tuple[Callable[[Evidence], CheckResult], ...]] = {
    "failures": (_finite,),
    CLAMPING: (_clamping,),
    "records": (_budget, _records),
    "undeclared stops": (_undeclared_stops,),
    "repeated points": (_repeated_points,),
    "ties": (_ties,),
    "below the optimum": (_below_optimum,),
    "same algorithm": (_same_algorithm,),
    "seeds": (_seeds, _random_streams),
    "times": (
        partial(_disturbed, "contention", "Trials waited for a core", WAITED),
        partial(_disturbed, "hidden_threads", "Trials used more than one core", THREADED),
    ),
}
"""What each check of finished trials looks for; :func:`bench.analysis.integrity` has further parts of the first two."""
