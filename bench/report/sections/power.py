"""The differences that the tests could detect with the number of trials made."""

from __future__ import annotations

from math import comb

import pandas as pd

from bench.analysis import power_table
from bench.report.findings import Findings
from bench.report.parts import Section, Table
from bench.report.wording import count

TITLE = "Power"


def section(findings: Findings) -> Section:
    """Return the differences that the Kolmogorov-Smirnov test can and cannot detect with this study's trials."""
    optimizers = len(findings.optimizers)
    if findings.frame.empty or optimizers < 2:
        return Section(TITLE, ("There is nothing to compare, so no test has any power.",))
    sizes = sorted(set(findings.trials))
    tables = pd.concat([power_table(n, comb(optimizers, 2)).assign(n=n) for n in sizes])
    shown = tables[["n", "level", "alpha", "distance", "shift"]].rename(
        columns={"distance": "D needed (of n)", "shift": "shift detected (SD)"}
    )
    blind = bool(tables.isna().any(axis=None))
    table = Table(
        "power",
        "The smallest distance D that is significant with n trials a cell, in units of 1/n, and the shift between two "
        "normal samples, in standard deviations (SD), that the test detects with a power of 80%.",
        shown,
        decimals={"alpha": 4, "D needed (of n)": 0, "shift detected (SD)": 2},
        note="–: even complete separation is not significant with so few trials." if blind else "",
        data=tables,
    )
    sentence = detectable_differences(sizes[0], optimizers)
    text = f"{sentence[0].upper()}{sentence[1:]}."
    return Section(TITLE, (text,), (table,), on_demand=True)  # the verdict has the sentence


def detectable_differences(n: int, optimizers: int) -> str:
    """Return a clause on the differences that n trials a cell detect with a power of 80%, and often miss below."""
    details, shifts = [], []
    for level, alpha, distance, shift in power_table(n, comb(optimizers, 2)).to_numpy():
        step = f"at {'alpha =' if level == 'alpha' else f'the {level} of'} {alpha:.2g} it"
        if pd.isna(shift):
            details.append(f"{step} can detect no difference at all")
        else:
            details.append(f"{step} needs D of at least {distance:.0f}/{n} and detects 80% of shifts of {shift:.2f} SD")
            shifts.append(f"{shift:.1f}")
    trials = f"with {count(n, 'trial')} in the smallest cell"
    if not shifts:
        return f"{trials} the test can detect no difference at all"
    return (
        f"{trials} the test would often miss shifts below about {' to '.join(dict.fromkeys(shifts))} SD "
        f"({'; '.join(details)})"
    )
