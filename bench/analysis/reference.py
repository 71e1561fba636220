"""Running times beside those of a published reference, such as the best algorithms of 2009, and targets from them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from bench.study.targets import RUN_LENGTHS

HARDEST = 1e-8
"""The hardest precision of a reference: nothing is known of harder ones."""

STEP = 10**0.2  # from one precision of COCO to the next
FORCED = (10**-0.2) ** -1  # the same as cocopp rounds it, which decides where two targets are nearly equal


def reference_times(reference: pd.DataFrame, functions: Mapping[str, str], levels: pd.DataFrame) -> pd.DataFrame:
    """Return ``levels`` with the ERT of a reference to each of its precisions, in a column ert.

    A precision between two of the reference stands for the next harder one, as for cocopp. The ERT is infinite where
    the reference has reached the function's easier precisions only, and missing below 1e-8 and on other functions.

    Args:
        reference: problem (the function in a dimension), precision and ert, in evaluations.
        functions: the name of the function of each problem.
        levels: columns problem and precision, which is positive.
    """
    table_of = {str(name): table.sort_values("precision") for name, table in reference.groupby("problem", sort=False)}
    ert = np.full(len(levels), np.nan)
    asked = levels["precision"].to_numpy(dtype=float)
    for problem, rows in levels.groupby("problem", sort=False).indices.items():
        if (function := functions[str(problem)]) in table_of:
            precisions, times = (table_of[function][name].to_numpy(dtype=float) for name in ("precision", "ert"))
            at = np.searchsorted(precisions, asked[rows] * (1 + 1e-9), side="right") - 1  # the easiest that is as hard
            ert[rows] = np.where(at >= 0, times[np.maximum(at, 0)], np.inf)
    return levels.assign(ert=np.where(asked < HARDEST * (1 - 1e-9), np.nan, ert))


def runlength_targets(
    reference: pd.DataFrame, functions: Mapping[str, str], dimensions: Mapping[str, int]
) -> pd.DataFrame:
    """Return the targets by running length: problem, length and precision, one row a problem and length.

    The precision for the length r is the next one of COCO's, five a decade, after the hardest whose ERT by the
    reference is at most r d evaluations. Where it would not be harder than that of the length before, it is one step
    harder than that, and 1e-8 is the last. So cocopp computes the targets of its tables for expensive functions
    (``RunlengthBasedTargetValues``), to the last bit. Functions without a reference have no row.

    Args:
        reference: as of :func:`reference_times`.
        functions: the name of the function of each problem.
        dimensions: the d of each problem.
    """
    table_of = {str(name): table.sort_values("precision") for name, table in reference.groupby("problem", sort=False)}
    rows = []
    for problem, function in functions.items():
        if function not in table_of:
            continue
        precisions, ert = (table_of[function][name].to_numpy(dtype=float)[::-1] for name in ("precision", "ert"))
        precisions = 10.0 ** (np.round(5 * np.log10(precisions)) / 5)
        last = np.inf
        for length in RUN_LENGTHS:
            within = np.flatnonzero(
                (ert <= max(1.0, length * dimensions[problem])) & (precisions >= HARDEST * (1 - 1e-9))
            )
            precision = (1 + 1e-9) * float(precisions[within[-1]]) / STEP if len(within) else float(precisions[0])
            last = precision if precision < last else last / FORCED
            rows.append((problem, length, max(last, HARDEST)))
    return pd.DataFrame(rows, columns=["problem", "length", "precision"])
