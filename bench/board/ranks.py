"""Rank the optimizers of many archives by one rule, only within a setting: the same problems and the same budget."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from bench.analysis.cells import merge_near_ties
from bench.analysis.standings import against_rivals, ranks, won
from bench.board.archive import Archive, Setting
from bench.typing import Floats

RULE = (
    "Optimizers are ranked against each other only where they ran the same problems (names, options and data) in the "
    "same dimension, with the same budget, the same handling of constraints and the same looks: each such setting has "
    "a table of its own, and no number of one table may be compared with a number of another. On each problem, an "
    "optimizer beats another one of the table where its trials more probably end lower (A12 > 0.5); its rank follows "
    "from the number of rivals that it beats, then from the mean A12 against them. Failed trials count as worst, and "
    "values equal to a relative 1e-10 as ties. The mean rank is that over all problems of the table, so it depends on "
    "which archives are on the board. It describes these trials and is no test."
)


@dataclass(frozen=True)
class SettingRanks:
    """The ranks of the optimizers of a setting.

    Attributes:
        setting: what all rows share.
        rows: an optimizer each, best first: place (equal mean ranks share the smallest), mean rank and mean A12 against
            the others, all missing where a problem has no trial; the trials on a problem, and where they are from.
        notes: sentences on what was left out.
    """

    setting: Setting
    rows: pd.DataFrame
    notes: tuple[str, ...]


def standings(archives: Sequence[Archive]) -> list[SettingRanks]:
    """Return the standing of each setting, in the order of suites, dimensions and budgets."""
    archives_of: dict[Setting, list[Archive]] = {}
    for archive in archives:
        for setting in archive.settings:
            archives_of.setdefault(setting, []).append(archive)
    return [_standing(setting, archives_of[setting]) for setting in sorted(archives_of)]


def _standing(setting: Setting, archives: Sequence[Archive]) -> SettingRanks:
    rows: list[dict[str, object]] = []
    ranked, notes = [], []
    seen: dict[tuple[object, ...], str] = {}
    for archive in archives:
        for entry in archive.study.optimizers:
            values = [archive.scores.get((label, entry.label), np.empty(0)) for label in setting.labels]
            content = (entry.name, repr(entry.options), *(scores.tobytes() for scores in values))
            shown = f"{entry.label} of {archive.name}"
            sizes = sorted({len(scores) for scores in values})
            if sizes[0] and (first := seen.setdefault(content, shown)) != shown:
                notes.append(f"{shown} has the trials of {first}, so it is left out.")
                continue
            ranked += [values] if sizes[0] else []
            trials = str(sizes[0]) if len(sizes) == 1 else f"{sizes[0]} to {sizes[-1]}"
            row = {"ranked": sizes[0] > 0, "optimizer": entry.label, "archive": archive.name, "trials": trials}
            rows.append({**row, **archive.provenance})
    frame = pd.DataFrame(rows)
    frame.insert(0, "mean rank", np.nan)
    frame.insert(1, "chance to end lower", np.nan)
    frame.loc[frame.pop("ranked"), ["mean rank", "chance to end lower"]] = np.column_stack(mean_ranks(ranked))
    frame.insert(0, "place", frame["mean rank"].rank(method="min").astype("Int64"))
    return SettingRanks(setting, frame.sort_values(["place", "archive", "optimizer"], ignore_index=True), tuple(notes))


def mean_ranks(values: Sequence[Sequence[Floats]]) -> tuple[Floats, Floats]:
    """Return the mean rank of each of k optimizers, (k,), and its mean A12 against the others, NaN without any.

    ``values`` are the scores of each optimizer's trials on each problem.
    """
    if not values:
        return np.empty(0), np.empty(0)
    means = []
    for column in zip(*values, strict=True):
        sizes = np.array([len(scores) for scores in column])
        pooled = merge_near_ties(np.concatenate(column))
        lower = won(pooled, np.repeat(np.arange(len(column)), sizes), np.ones((1, len(pooled))))[0].T
        beaten, chance = against_rivals(lower / np.outer(sizes, sizes), axis=1)
        means.append((ranks(beaten, chance), chance if len(column) > 1 else np.full(1, np.nan)))
    mean, chance = np.mean(means, axis=0)
    return np.round(mean, 9), chance
