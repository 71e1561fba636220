"""The optimizers beside the best of 2009, COCO's reference on bbob and bbob-noisy."""

from __future__ import annotations

import numpy as np
import pandas as pd

from bench.report.parts import Section, Table
from bench.report.wording import count, listing
from bench.topics.findings import Anytime, Findings

TITLE = "Beside the best of 2009"


def section(findings: Findings) -> Section | None:
    """Return the ERT of each optimizer over that of the best of 2009; None unless asked for."""
    if not findings.anytime.beside_best:
        return None
    ratios = _ratios(findings)
    about = (
        "The best of 2009 is no algorithm: for each function, dimension and target it is the lowest expected running "
        "time (ERT) of the 31 algorithms of the BBOB workshop of 2009 (Hansen et al. 2010), chosen afterwards for each "
        "target. They ran on instances of 2009, three times each. The times are read from the package cocopp."
    )
    without = len(findings.trials.problems) - ratios["problem"].nunique()
    text = [about, *_sentences(findings.anytime, ratios)]
    if without:
        text.append(f"{count(without, 'problem')} without such a time, or whose optimum was beaten, are left out.")
    return Section(TITLE, tuple(text), (_table(findings, ratios),) if len(ratios) else ())


def _ratios(findings: Findings) -> pd.DataFrame:
    """Return finite ratios of ERTs to those of the best of 2009: problem, precision, optimizer, ratio, …"""
    unit = findings.anytime.target_set.unit
    table = findings.anytime.running_times
    rows = table[np.isfinite(table["best2009"].astype(float))]
    return rows[["problem", "optimizer", unit, "trials", "successes", "ert", "best2009"]].assign(
        ratio=rows["ert"].astype(float) / rows["best2009"].astype(float),
        dimension=rows["problem"].astype(object).map(findings.trials.dimensions),
    )


def _sentences(anytime: Anytime, ratios: pd.DataFrame) -> list[str]:
    """Return on how many problems each optimizer needs no more evaluations than the best of 2009."""
    sentences = []
    for level in anytime.target_set.levels:
        at_level = ratios[np.isclose(ratios[anytime.target_set.unit].astype(float), level)]
        if at_level.empty:
            continue
        problems = count(at_level["problem"].nunique(), "problem")
        wins = (at_level["ratio"] <= 1).groupby(at_level["optimizer"].astype(object)).sum().sort_values(ascending=False)
        parts = [f"{label} on {number:,}" for label, number in wins.items() if number]
        if parts:
            parts[0] = (
                f"{wins.index[0]} needed no more evaluations than the best of 2009 on {wins.iloc[0]:,} of {problems}"
            )
        who = (
            listing(parts) if parts else f"every optimizer needed more evaluations than the best of 2009 on {problems}"
        )
        sentences.append(f"To {anytime.target_set.at(level)}, {who}.")
    return [" ".join(sentences)] if sentences else []


def _table(findings: Findings, ratios: pd.DataFrame) -> Table:
    unit, levels = findings.anytime.target_set.unit, findings.anytime.target_set.levels
    rows = ratios[np.isclose(ratios[unit].astype(float).to_numpy()[:, np.newaxis], levels).any(axis=1)]
    keys = [rows["dimension"], rows[unit].astype(float)]
    wide = rows["ratio"].groupby([*keys, rows["optimizer"].astype(object)]).median().unstack()
    wide = wide.sort_index(ascending=[True, False]).reindex(columns=findings.trials.optimizers)
    problems = rows["problem"].astype(object).groupby(keys).nunique().reindex(wide.index)
    names = [f"d = {dimension:g}, {findings.anytime.target_set.at(level)}" for dimension, level in wide.index]
    shown = wide.set_axis(pd.Index(names, name="dimension and target")).rename_axis(columns=None)
    lowest = shown.eq(shown.min(axis=1), axis=0) & np.isfinite(shown)
    shown.insert(0, "problems", problems.to_numpy())
    return Table(
        "best2009",
        "The expected running time (ERT) over that of the best of 2009: the median over the problems whose target the "
        "best of 2009 reached.",
        shown,
        bold=lowest,
        note="Below 1: fewer evaluations than the best of 2009. ∞: no trial succeeded on half of the problems or more. "
        "Bold: the lowest of a row. The CSV file has every problem and target.",
        data=findings.anytime.target_set.in_unit(ratios, unit),
    )
