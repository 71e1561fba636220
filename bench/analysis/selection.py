"""Choose an optimizer by the features of a problem's landscape, and validate the choice by leaving functions out.

The choice is that of nearest neighbours: the optimizer with the highest mean score on the problems whose features are
most alike. A validation leaves out all instances and dimensions of a function at a time, as those of one function are
nearly the same problem (Bischl, Mersmann, Trautmann and Preuss 2012, GECCO).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial.distance import cdist

from bench.analysis.cells import labels
from bench.analysis.portfolio import over_functions, student

NEIGHBOURS = 5
LEAST_FUNCTIONS = 6  # for a validation
SHOWN = 3  # optimizers of an advice


def feature_distances(features: pd.DataFrame, problems: pd.DataFrame) -> pd.DataFrame:
    """Return the distance of each of the ``problems`` (rows) to each problem that ``features`` has (columns).

    Both have features by problem, ``dimension`` among them. They are standardised by those of ``features``, each group
    with the same weight. Features enter as their asinh, since ratios reach 1e10, a dimension as its logarithm. A
    feature that is missing or equal on all problems is left out, and one that a problem lacks counts as the mean. A
    distance is the root of the mean over groups of the mean squared difference, 1.4 between problems that have nothing
    in common.
    """
    values = _moderate(features)
    used = values[[name for name in values if values[name].max() > values[name].min()]]
    groups = pd.Series([str(name).partition(".")[0] for name in used], dtype=object)
    sizes = groups.map(groups.value_counts()).to_numpy(dtype=float)
    scale = used.std(ddof=0).to_numpy(dtype=float) * np.sqrt(sizes * max(groups.nunique(), 1))
    mean = used.mean().to_numpy(dtype=float)
    tables = used, _moderate(problems).reindex(columns=used.columns)
    here, there = (np.nan_to_num((table.to_numpy(dtype=float) - mean) / scale) for table in tables)
    return pd.DataFrame(cdist(there, here), index=problems.index, columns=features.index)


def _moderate(table: pd.DataFrame) -> pd.DataFrame:
    """Return features of moderate size: asinh, of a dimension its logarithm."""
    values = pd.DataFrame(np.arcsinh(table.to_numpy(dtype=float)), table.index, table.columns)
    return values.assign(dimension=np.log(table["dimension"].astype(float))) if "dimension" in table else values


def cell_scores(scores: pd.DataFrame) -> pd.DataFrame:
    """Return the mean score of each cell, problems by optimizers, of problems on which every optimizer has a trial."""
    order = list(dict.fromkeys(scores["problem"]))
    wide = scores.astype({"problem": object, "optimizer": object}).pivot_table(
        index="problem", columns="optimizer", values="score", aggfunc="mean"
    )
    return wide.reindex(index=order, columns=labels(scores, "optimizer")).dropna().round(12)


def single_best(table: pd.DataFrame, blocks: Mapping[str, str]) -> str:
    """Return the optimizer with the highest mean score over functions; ``table`` is that of :func:`cell_scores`."""
    return str(over_functions(table, blocks).mean().round(12).idxmax())


def validated_selection(
    features: pd.DataFrame, scores: pd.DataFrame, charged: pd.DataFrame, blocks: Mapping[str, str]
) -> pd.DataFrame:
    """Return the optimizer that features choose for each problem, learnt without the problems of its function.

    Columns: problem, function, nearest (the neighbour), chosen, ``score`` (charged), ``single_score`` (of the single
    best of all these problems), ``gain`` (the difference, positive where the choice is better). Empty with fewer than
    6 functions.

    The single best is chosen on the trials that score it, so the gain of useless features is below 0. One that is
    chosen anew without each function would be unbiased, but then gains depend on each other, and their interval lies
    above 0 in 14% of studies of 24 functions and equal optimizers (``validation/portfolio.py``).

    Args:
        features: by problem, ``dimension`` among them; problems without are left out.
        scores: those of :func:`bench.analysis.target_shares`.
        charged: the same with the evaluations of the feature sample charged.
        blocks: the function of each problem.
    """
    plain, paid = (cell_scores(trial_scores) for trial_scores in (scores, charged))
    compared = [problem for problem in plain.index if problem in features.index and problem in paid.index]
    functions = np.array([blocks.get(problem, problem) for problem in compared], dtype=object)
    plain, paid, described = plain.loc[compared], paid.loc[compared], features.loc[compared]
    rows: list[tuple[Any, ...]] = []
    if len(set(functions)) >= LEAST_FUNCTIONS:
        values, single = paid.to_numpy(dtype=float), plain[single_best(plain, blocks)].to_numpy(dtype=float)
        for function in dict.fromkeys(functions):
            test, train = np.flatnonzero(functions == function), np.flatnonzero(functions != function)
            apart = feature_distances(described.iloc[train], described.iloc[test]).to_numpy()
            near = train[apart.argsort(axis=1, kind="stable")[:, :NEIGHBOURS]]
            for place, neighbours in zip(test, near, strict=True):
                chosen = values[neighbours].mean(axis=0).round(12).argmax()
                score = values[place, chosen]
                names = (compared[place], function, compared[neighbours[0]], paid.columns[chosen])
                rows.append((*names, score, single[place], score - single[place]))
    columns = ["problem", "function", "nearest", "chosen", "score", "single_score", "gain"]
    return pd.DataFrame(rows, columns=columns)


def selection_gain(validated: pd.DataFrame) -> tuple[float, float, float]:
    """Return the mean gain of :func:`validated_selection` over functions, and its interval; missing where empty."""
    if validated.empty:
        return np.nan, np.nan, np.nan
    return student(validated.groupby("function", sort=False)["gain"].mean().to_list())


def usual_reach(features: pd.DataFrame, blocks: Mapping[str, str]) -> float:
    """Return how far a problem is from the nearest problem of another function, at most; missing for one function."""
    apart = feature_distances(features, features)
    functions = np.array([blocks.get(str(problem), str(problem)) for problem in apart.index], dtype=object)
    apart_by_function = apart.where(functions[:, np.newaxis] != functions[np.newaxis])
    return float(apart_by_function.min(axis=1).max())


def best_on(
    problems: Sequence[str], scores: pd.DataFrame, charged: pd.DataFrame, blocks: Mapping[str, str]
) -> pd.DataFrame:
    """Return the best three optimizers on some problems, beside the single best of all.

    Columns: optimizer, ``score``, the mean over these problems, and ``gain``, ``low`` and ``high``: how much that is
    above the score of the single best, with the interval over the functions of these problems. As the same problems
    choose, gains are too large rather than too small.

    Args:
        problems: such as those with the most similar features.
        scores: as in :func:`validated_selection`.
        charged: likewise, or ``scores`` where nothing is charged.
        blocks: likewise.
    """
    plain, paid = (cell_scores(trial_scores) for trial_scores in (scores, charged))
    here = paid.loc[[problem for problem in problems if problem in plain.index]]
    gains = here.sub(plain.loc[here.index, single_best(plain, blocks)], axis=0)
    best = here.mean().round(12).sort_values(ascending=False, kind="stable").index[:SHOWN]
    rows = [(label, here[label].mean(), *student(over_functions(gains[label], blocks).to_list())) for label in best]
    return pd.DataFrame(rows, columns=["optimizer", "score", "gain", "low", "high"])
