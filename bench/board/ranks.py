"""Rank the optimizers of many archives by one rule, only within a setting: the same problems and the same budget."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.analysis.cells import merge_near_ties
from bench.analysis.standings import against_rivals, ranks, won
from bench.board.archive import Archive, Setting
from bench.study import Entry
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
class Row:
    """An optimizer in a table.

    Attributes:
        archive: the archive that its trials are from.
        optimizer: its entry in the study.
        mean_rank: the mean rank over the problems, NaN where a problem has no trial.
        chance: the mean A12 against the others.
        place: 1 for the lowest mean rank; equal ones share the smallest place; 0 without a rank.
        trials: the numbers of trials on a problem, the smallest and the largest.
    """

    archive: Archive
    optimizer: Entry
    mean_rank: float
    chance: float
    place: int
    trials: tuple[int, int]


@dataclass(frozen=True)
class Standing:
    """The rows of a setting, best first, and sentences on what was left out."""

    setting: Setting
    rows: tuple[Row, ...]
    notes: tuple[str, ...]


def standings(archives: Sequence[Archive]) -> list[Standing]:
    """Return the standing of each setting, in the order of suites, dimensions and budgets."""
    found: dict[Setting, list[Archive]] = {}
    for each in archives:
        for setting in each.settings:
            found.setdefault(setting, []).append(each)
    return [_standing(setting, found[setting]) for setting in sorted(found)]


def _standing(setting: Setting, archives: Sequence[Archive]) -> Standing:
    entries: list[tuple[Archive, Entry, list[Floats]]] = []
    rows: list[Row] = []
    seen: dict[tuple[object, ...], str] = {}
    notes = []
    for archive in archives:
        for entry in archive.study.optimizers:
            values = [archive.scores.get((label, entry.label), np.empty(0)) for label in setting.labels]
            content = (entry.name, repr(entry.options), *(each.tobytes() for each in values))
            shown = f"{entry.label} of {archive.name}"
            if not all(map(len, values)):
                rows.append(Row(archive, entry, np.nan, np.nan, 0, _least_and_most(values)))
            elif (first := seen.setdefault(content, shown)) != shown:
                notes.append(f"{shown} has the trials of {first}, so it is left out.")
            else:
                entries.append((archive, entry, values))
    mean, chance = mean_ranks([values for _, _, values in entries])
    for (archive, entry, values), rank, own in zip(entries, mean, chance, strict=True):
        rows.append(Row(archive, entry, rank, own, int(np.sum(mean < rank)) + 1, _least_and_most(values)))
    rows.sort(key=lambda row: (not row.place, row.place, row.archive.name, row.optimizer.label))
    return Standing(setting, tuple(rows), tuple(notes))


def mean_ranks(values: Sequence[Sequence[Floats]]) -> tuple[Floats, Floats]:
    """Return the mean rank of each of k optimizers, (k,), and its mean A12 against the others, NaN without any.

    ``values`` are the scores of each optimizer's trials on each problem.
    """
    if not values:
        return np.empty(0), np.empty(0)
    found = []
    for own in zip(*values, strict=True):
        sizes = np.array([len(each) for each in own])
        pooled = merge_near_ties(np.concatenate(own))
        lower = won(pooled, np.repeat(np.arange(len(own)), sizes), np.ones((1, len(pooled))))[0].T
        beaten, chance = against_rivals(lower / np.outer(sizes, sizes), axis=1)
        found.append((ranks(beaten, chance), chance if len(own) > 1 else np.full(1, np.nan)))
    mean, chance = np.mean(found, axis=0)
    return np.round(mean, 9), chance


def _least_and_most(values: Sequence[Floats]) -> tuple[int, int]:
    sizes = [len(each) for each in values]
    return min(sizes), max(sizes)
