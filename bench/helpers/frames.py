"""The labels in a frame of trials."""

from __future__ import annotations

import pandas as pd


def labels(frame: pd.DataFrame, column: str) -> list[str]:
    """Return the labels of ``problem`` or ``optimizer``: the study's where known, else in order of appearance."""
    values = frame[column]
    if isinstance(values.dtype, pd.CategoricalDtype):
        return list(values.cat.categories)
    return list(values.unique())
