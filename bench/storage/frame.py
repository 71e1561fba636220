"""Build the tidy frame, one row a trial, in slices, as a study may have millions of rows."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from itertools import islice

import numpy as np
import pandas as pd

from bench.errors import BenchError
from bench.trial import FRAME_COLUMNS, Row

COLUMNS = (*FRAME_COLUMNS, "environment")
SLICE = 50_000  # rows held as Python objects at a time


def tidy(rows: Iterable[Row], problems: Sequence[str], optimizers: Sequence[str]) -> pd.DataFrame:
    """Return the tidy frame of a store's rows.

    Args:
        rows: each with all ``COLUMNS``, and ``x`` and ``figures`` as JSON texts or None.
        problems: all problems, in the order of the frame.
        optimizers: all optimizers, in the order of the frame.

    Returns:
        ``COLUMNS``, one ``x_<variable>`` for each variable of any problem, and one column for each domain metric;
        sorted by problem, optimizer and trial.

    Raises:
        BenchError: for a row with a damaged text.
    """
    left = iter(rows)
    parts: dict[str, list[pd.DataFrame]] = {"own": [], "x": [], "figures": []}
    while slice_ := list(islice(left, SLICE)):
        parts["own"].append(pd.DataFrame({name: [row[name] for row in slice_] for name in COLUMNS}))
        for name in ("x", "figures"):
            parts[name].append(pd.DataFrame(_parsed(slice_, name)))
    if not parts["own"]:
        return pd.DataFrame(columns=[*COLUMNS])
    own, points, figures = (pd.concat(each, ignore_index=True) for each in parts.values())
    frame = pd.concat([own, points.add_prefix("x_"), figures], axis=1)
    ranks = [
        frame[name].map({label: rank for rank, label in enumerate(labels)})
        for name, labels in (("problem", problems), ("optimizer", optimizers))
    ]
    order = np.lexsort((frame["trial"], ranks[1], ranks[0]))
    return frame.iloc[order].reset_index(drop=True)


def _parsed(rows: list[Row], name: str) -> list[dict[str, float]]:
    """Parse the JSON text of every row, all in one call unless one of them is damaged."""
    try:
        parsed: list[dict[str, float]] = json.loads(f"[{','.join(row[name] or '{}' for row in rows)}]")
    except ValueError:
        parsed = []
    if len(parsed) == len(rows) and all(isinstance(each, dict) for each in parsed):
        return parsed
    row = next((row for row in rows if not _is_sound(row[name] or "{}")), rows[0])
    raise BenchError(
        f"the store is damaged: {name!r} of trial {row['trial']} of {row['optimizer']} on {row['problem']} (study "
        f"{row['study']}) cannot be read; restore it from a copy"
    )


def _is_sound(text: str) -> bool:
    try:
        return isinstance(json.loads(text), dict)
    except ValueError:
        return False
