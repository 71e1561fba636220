"""The expected running times of all functions in one dimension as one table, as COCO prints them."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from bench.analysis.running_time import separably_fastest
from bench.report.parts import Table
from bench.topics.findings import BEST, Findings

PRECISION = "target precision"  # of a row beside the optimizers

Row = Mapping[Hashable, Any]  # of the running times


def ert_table(findings: Findings, problems: Mapping[str, str], dimension: int) -> Table:
    """Return the ERT of each optimizer on problems, whose names are given, over the best of 2009 or in evaluations.

    In brackets is the dispersion, half the range from the 10th to the 90th percentile of simulated restarts, in the
    same unit. A star marks an optimizer that is separably faster than every other one. Where targets differ by function
    (by running length), a row has the precision of each.
    """
    anytime = findings.anytime
    chosen, times = anytime.target_set, anytime.running_times
    rows_of_suite = times[times["problem"].isin(problems)]
    row_of: dict[tuple[str, str, float], Row] = {
        (row["problem"], row["optimizer"], row[chosen.unit]): row for row in rows_of_suite.to_dict("records")
    }
    levels = [level for level in chosen.tabled if (rows_of_suite[chosen.unit] == level).any()]
    best = {(row["problem"], row["tau"]): float(row["ert"]) for row in anytime.best_times.to_dict("records")}
    precisions = anytime.precisions_at(levels)
    hits = findings.anytime.compared_hits
    hits = hits[hits["problem"].isin(problems)]
    at = np.isclose(hits["tau"].to_numpy(dtype=float)[:, np.newaxis], levels, rtol=1e-9, atol=0)
    hits = hits[at.any(axis=1)].assign(tau=np.array(levels)[at[at.any(axis=1)].argmax(axis=1)])
    fastest = separably_fastest(hits)
    stars = set(zip(fastest["problem"], fastest["optimizer"], fastest["tau"], strict=True))
    rows: dict[tuple[str, str], list[str]] = {}
    bold, marks = [], []
    for problem, name in problems.items():
        divisors = [best.get((problem, level), np.nan) for level in levels]
        beside = {PRECISION: precisions.get(problem), BEST: divisors if anytime.shows_best else None}
        for row_name, values in beside.items():
            if values is not None:
                rows[name, row_name] = [*map(_short, values), ""]
                bold.append([False] * (len(levels) + 1))
                marks.append([""] * (len(levels) + 1))
        lowest = rows_of_suite[rows_of_suite["problem"] == problem].groupby(chosen.unit)["ert"].min()
        for optimizer in findings.trials.optimizers:
            cells = [row_of.get((problem, optimizer, level)) for level in levels]
            last = cells[-1] if cells else None
            rows[name, optimizer] = [
                *(
                    _cell(cell, best_ert, ratio=anytime.shows_best)
                    for cell, best_ert in zip(cells, divisors, strict=True)
                ),
                f"{last['successes']:.0f}/{last['trials']:.0f}" if last else "",
            ]
            least = [
                bool(cell and np.isfinite(cell["ert"]) and cell["ert"] == lowest[level])
                for cell, level in zip(cells, levels, strict=True)
            ]
            bold.append([*least, False])
            marks.append([*("*" if (problem, optimizer, level) in stars else "" for level in levels), ""])
    index = pd.MultiIndex.from_tuples(list(rows), names=["function", "optimizer"])
    frames = [
        pd.DataFrame(content, index=index, columns=[*map(chosen.level_text, levels), "successes"])
        for content in (list(rows.values()), bold, marks)
    ]
    over = "over that of the best of 2009" if anytime.shows_best else "in evaluations"
    return Table(
        f"running-times-d{dimension}",
        f"Expected running time (ERT) {over} to each target, by {chosen.unit}, in dimension {dimension}.",
        frames[0],
        bold=frames[1],
        marks=frames[2],
        note="In brackets: half the range from the 10th to the 90th percentile of simulated restarts, in the same "
        "unit. ∞: no trial succeeded, with the median evaluations of the trials. Successes: at the last target. Bold: "
        "the lowest. *: faster than each other one by the test of A12 = 0.5, p < 0.05 after Holm’s adjustment for "
        "all functions and targets of this table."
        + (f" {PRECISION.capitalize()}: the value less the optimum that counts as reached." if precisions else "")
        + (" The best of 2009 is in evaluations; where it is unknown, so are the others (ev.)." if best else ""),
        data=chosen.in_unit(rows_of_suite, chosen.unit),
    )


def _cell(row: Row | None, divisor: float, *, ratio: bool) -> str:
    """Return an ERT with its dispersion, as ratios to a finite divisor."""
    if row is None or pd.isna(row["ert"]):
        return "–"
    if np.isinf(row["ert"]):
        return f"∞ ({_short(row['unsuccessful'])})"
    scale = divisor if ratio and np.isfinite(divisor) else 1.0
    spread = (row["p90"] - row["p10"]) / 2
    unit = "" if scale == divisor or not ratio else " ev."
    return f"{_short(row['ert'] / scale)} ({_short(spread / scale)}){unit}"


def _short(value: float) -> str:
    """Return two significant digits, and all digits before the point."""
    if pd.isna(value) or np.isinf(value):
        return "–" if pd.isna(value) else "∞"
    return f"{value:,.0f}" if value >= 9.95 else f"{value:.1f}" if value >= 0.995 else f"{value:.2g}"
