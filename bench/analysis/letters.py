"""Compact letter display: which optimizers of a problem are not separable, in letters instead of a table of pairs."""

from __future__ import annotations

import numpy as np
import pandas as pd

from bench.analysis.pairwise import ALPHA


def compact_letters(summary: pd.DataFrame, pairs: pd.DataFrame, alpha: float = ALPHA) -> pd.DataFrame:
    """Return problem, optimizer and letters of every cell (Piepho 2004, J. Comput. Graph. Stat. 13).

    Two optimizers share a letter where they are not separable: p_holm > ``alpha``. Letters are assigned from the lowest
    median up, so the best has an "a". "" stands for a cell without trials, "?" for every cell of a problem that needs
    more than 52 letters.

    Args:
        summary: from :func:`bench.analysis.summarise`; only its optimizers get letters.
        pairs: from :func:`bench.analysis.pairwise_tests`.
        alpha: the level.
    """
    letters = {
        (problem, optimizer): text
        for problem, own in summary[summary["n"] > 0].groupby("problem", sort=False)
        for optimizer, text in _display(
            list(own.sort_values("median", kind="stable")["optimizer"]), pairs[pairs["problem"] == problem], alpha
        ).items()
    }
    cells = summary[["problem", "optimizer"]]
    return cells.assign(letters=[letters.get(cell, "") for cell in cells.itertuples(index=False, name=None)])


def _display(optimizers: list[str], pairs: pd.DataFrame, alpha: float) -> dict[str, str]:
    """Return the letters of each optimizer of one problem, the first one's from "a" on."""
    from scikit_posthocs import compact_letter_display  # slow: it imports the drawing libraries

    place = {optimizer: i for i, optimizer in enumerate(optimizers)}
    alike = np.ones((len(place), len(place)))
    for first, second, p in zip(pairs["first"], pairs["second"], pairs["p_holm"], strict=True):
        if first in place and second in place:
            i, j = place[first], place[second]
            alike[i, j] = alike[j, i] = p > alpha  # the library's own rule differs at p = alpha
    try:
        shown = compact_letter_display(alike, alpha=0.5, names=optimizers)
    except ValueError:  # more groups than letters
        return dict.fromkeys(optimizers, "?")
    return {optimizer: text.replace(" ", "") for optimizer, text in shown.items()}
