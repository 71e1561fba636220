"""Running times beside those of a published reference, such as the best algorithms of 2009."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

HARDEST = 1e-8
"""The hardest precision of a reference: nothing is known of harder ones."""


def reference_times(reference: pd.DataFrame, functions: Mapping[str, str], precisions: Sequence[float]) -> pd.DataFrame:
    """Return the ERT of a reference at precisions: problem, precision and ert, one row a problem and precision.

    A precision between two of the reference stands for the next harder one, as for cocopp. The ERT is infinite where
    the reference has reached the function's easier precisions only, and missing below 1e-8 and on other functions.

    Args:
        reference: problem (the function in a dimension), precision and ert, in evaluations.
        functions: the name of the function of each problem.
        precisions: (T,) positive.
    """
    own = {str(name): table.sort_values("precision") for name, table in reference.groupby("problem", sort=False)}
    asked = np.asarray(precisions, dtype=float)
    tables = []
    for problem, function in functions.items():
        ert = np.full(len(asked), np.nan)
        if function in own:
            known, times = (own[function][name].to_numpy(dtype=float) for name in ("precision", "ert"))
            at = np.searchsorted(known, asked * (1 + 1e-9), side="right") - 1  # the easiest that is as hard
            ert = np.where(at >= 0, times[np.maximum(at, 0)], np.inf)
            ert[asked < HARDEST * (1 - 1e-9)] = np.nan
        tables.append(pd.DataFrame({"problem": problem, "precision": asked, "ert": ert}))
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=["problem", "precision", "ert"])
