"""Sets of targets: absolute precisions, quantiles of what was found, and terms of the domain; and what depends on them.

A set is a table like that of :func:`bench.analysis.targets`, so that hitting times, running times, success rates and
ECDF follow from any of them. ``tau`` says how hard a target is, in the unit of its set.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import median

import numpy as np
import pandas as pd

from bench.analysis.cells import Budgets, Traces, budgets, reference_values, scores, spent, traces_of
from bench.contract.objective import Trace
from bench.study.targets import MULTIPLES, Found, Targets

LOWEST, HIGHEST = 1e-8, 1e2
"""The precisions between which AOCC is measured."""

COLUMNS = ["problem", "tau", "target", "reference", "known"]

Expected = Mapping[str, Mapping[str, tuple[float, float]]]  # by problem and metric: the true value and its tolerance


def targets(traces: Traces, optima: Mapping[str, float] | None = None) -> pd.DataFrame:
    """Return the ladder of relative targets of each problem: problem, tau, target, reference and known.

    A target is f_L + tau (f_0 - f_L). f_0 is the median, over all trials of the problem, of the first finite value
    in a trial's trace. f_L, the ``reference``, is the optimum where that is ``known``, or the lowest value that any
    trial found where the optimum is unknown or beaten (``bench.analysis.reference_values``); targets then depend on
    the optimizers compared, and the ladder is the short one.

    Where f_0 is not above f_L, the only target is f_L itself, with tau = 0. A problem on which no trial found a finite
    value has no target. The table is in the order in which problems appear in ``traces``.
    """
    return target_table("relative", pd.DataFrame({"problem": [], "fun": [], "status": []}), traces, optima)


def target_table(
    chosen: Targets | str | Sequence[float] | Sequence[str],
    frame: pd.DataFrame,
    traces: Traces,
    optima: Mapping[str, float] | None = None,
) -> pd.DataFrame:
    """Return the targets of a set on each problem, from easy to hard: problem, tau, target, reference and known.

    ``reference`` is the optimum where that is ``known``, or the lowest value found where it is unknown or beaten
    (``bench.analysis.reference_values``). A problem on which no trial found a finite value has no target.

    ================  ========================  =====================================================================
    chosen            tau                       target
    ================  ========================  =====================================================================
    ``"relative"``    share of the distance     that of :func:`bench.analysis.targets`
    ``"precisions"``  precision                 reference + tau, for COCO's 51 precisions; a list has its own
    ``["5%", "1%"]``  share of the reference    reference + tau abs(reference); none where the reference is 0
    ``"quantiles"``   quantile                  the value that this share of all trials reached; none where it is inf
    ``"tolerance"``   multiple of the           the same multiple; ``tolerance_times`` has the times, as the values
                      tolerance                 of a trace do not show a metric
    ``"runlength"``   d / budget                none; ``bench.analysis.runlength_targets`` has them
    ================  ========================  =====================================================================
    """
    rungs = Targets.read(chosen).rungs
    ends: dict[str, list[tuple[float, float]]] = {}
    for (problem, _, _), trace in traces.items():
        if len(trace.values):
            ends.setdefault(problem, []).append((float(trace.values[0]), float(trace.values[-1])))
    lowest = {problem: min(last for _, last in pairs) for problem, pairs in ends.items()}
    finals = {
        str(problem): np.asarray(of_problem, dtype=np.float64)
        for problem, of_problem in scores(frame).groupby(frame["problem"].astype(object))
    }
    tables = []
    for problem, (reference, known) in reference_values(lowest, optima).items():
        first = median(value for value, _ in ends[problem])
        tau, target = rungs(Found(reference, known, first, finals.get(problem, np.empty(0))))
        table = pd.DataFrame({"problem": problem, "tau": tau, "target": target, "reference": reference, "known": known})
        tables.append(table[~np.isnan(target)])
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=COLUMNS)


def tolerance_times(frame: pd.DataFrame, traces: Traces, expected: Expected, budget: Budgets) -> pd.DataFrame:
    """Return the times to multiples of the tolerance of expected metrics, as :func:`bench.analysis.hitting_times`.

    A trial reaches a multiple when all expected metrics of its best point differ from their true values by at most
    that multiple of their tolerances; the time is the evaluation that found this point. Metrics of points on the way
    are not recorded. Trials of a problem without an expected metric have no row.
    """
    trials = frame[frame["problem"].isin([problem for problem, metrics in expected.items() if metrics])]
    off, unknown = np.zeros(len(trials)), pd.Series(np.nan, index=trials.index)
    for problem, metrics in expected.items():
        here = (trials["problem"] == problem).to_numpy()
        for metric, (true, tolerance) in metrics.items():
            metric_values = pd.to_numeric(trials.get(metric, unknown)[here], errors="coerce")
            difference = (metric_values.astype(float) - true).abs().to_numpy()
            share = difference / tolerance if tolerance > 0 else np.where(difference == 0, 0.0, np.inf)
            off[here] = np.maximum(off[here], np.where(np.isfinite(share), share, np.inf))
    ends = [np.append(np.inf, trace.evaluations)[-1] for trace in traces_of(trials, traces)]
    rows, tau = np.repeat(np.arange(len(trials)), len(MULTIPLES)), np.tile(MULTIPLES, len(trials))
    reached = np.where(off[rows] <= tau * (1 + 1e-12), np.array(ends)[rows], np.inf)
    hits = trials[["problem", "optimizer", "trial"]].iloc[rows].reset_index(drop=True)
    return hits.assign(tau=tau, target=tau, evaluations=reached, spent=spent(trials, budget)[rows])


def aocc(
    frame: pd.DataFrame, traces: Traces, optima: Mapping[str, float], budget: int | Mapping[str, int]
) -> pd.DataFrame:
    """Return the area over the convergence curve of each cell on the problems of ``optima``.

    Columns: problem, optimizer, trials, ``aocc`` and ``aocc_from_zero``, means over trials. The AOCC of a trial with
    budget B is (1/B) sum_i (1 - (clip(log10 y_i, -8, 2) + 8) / 10), where y_i is the best precision after evaluation
    i = 1 … B (van Stein et al. 2024); 1 is best. A trial that ended early keeps its last value. A failed trial has 0.
    ``aocc_from_zero`` is what iohinspector computes, an integral from 0 to B of a curve that begins with the first
    value: it differs by the last share less the first, over B.
    """
    trials = frame[frame["problem"].isin(optima)]
    allowed = budgets(trials, budget).to_numpy()
    area, start, end = np.zeros((3, len(trials)))
    for row, (problem, trace) in enumerate(zip(trials["problem"], traces_of(trials, traces), strict=True)):
        area[row], start[row], end[row] = area_over_curve(trace, optima[problem], allowed[row])
    table = trials[["problem", "optimizer"]].assign(aocc=area, aocc_from_zero=area - (end - start) / allowed)
    if table.empty:
        return pd.DataFrame(columns=["problem", "optimizer", "trials", "aocc", "aocc_from_zero"])
    names = ["problem", "optimizer"]
    groups = table.astype(dict.fromkeys(names, object)).groupby(names, sort=False)
    means = groups.mean()
    return means.assign(trials=groups.size()).reset_index()[[*names, "trials", "aocc", "aocc_from_zero"]]


def area_over_curve(trace: Trace, optimum: float, budget: int) -> tuple[float, float, float]:
    """Return the AOCC of a trial (:func:`aocc`), and the shares of its first and its last evaluation."""
    if not len(trace.values):
        return 0.0, 0.0, 0.0
    share = 1 - (np.log10(np.clip(trace.values - optimum, LOWEST, HIGHEST)) + 8) / 10
    held = np.diff(trace.evaluations, append=budget + 1)
    return float((share * held).sum() / budget), float(share[0]) if trace.evaluations[0] == 1 else 0.0, float(share[-1])
