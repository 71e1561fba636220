"""One optimizer against each of its rivals: the *subject* of a study, which its author asks about.

Only the k - 1 pairs with the subject are hypotheses, not all k (k - 1) / 2.
"""

from __future__ import annotations

import numpy as np
import pandas as pd


def seen_from(tests: pd.DataFrame, optimizer: str) -> pd.DataFrame:
    """Return the pairs of an optimizer with it as the first one; probabilities and intervals are turned round."""
    turned = tests[tests["second"] == optimizer].rename(columns={"first": "second", "second": "first"})
    ends = {"low": "high", "joint_low": "joint_high"}
    both = ends | {high: low for low, high in ends.items()} | {"probability": "probability"}
    turned = turned.assign(**{name: 1 - turned[other] for name, other in both.items() if other in turned})
    return pd.concat([tests[tests["first"] == optimizer], turned])


def signs_of(summary: pd.DataFrame, pairs: pd.DataFrame, subject: str) -> pd.DataFrame:
    """Return problem, optimizer and sign of every cell: the sign of the subject's test against it.

    "+" where the subject is separably lower, "−" where the other one is, "=" where neither is, "" of the subject and
    where nothing is tested. ``summary`` and ``pairs`` are those of :func:`bench.analysis.comparison_matrix`.
    """
    rivals = seen_from(pairs.astype({"first": object, "second": object, "lower": object}), subject)
    own = rivals[rivals["testable"].astype(bool) & rivals["a12"].notna()]
    sign = np.where(own["lower"] == subject, "+", np.where(own["lower"] == "", "=", "−"))
    signs = dict(zip(zip(own["problem"], own["second"], strict=True), sign, strict=True))
    cells = summary[["problem", "optimizer"]]
    return cells.assign(sign=[signs.get(cell, "") for cell in cells.itertuples(index=False, name=None)])
