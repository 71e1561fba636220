"""The panels of the figure of all runs, and the one axis that they share."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from bench.analysis.cells import scores
from bench.analysis.instances import SOLVED
from bench.topics.findings import Findings, Trials

MOST = 40  # problems with a panel each; above, functions or classes have one
NARROW = 10.0  # times the lowest value, up to which an axis of ratios is linear
FLOOR = 1e-6  # smaller distances from the lowest value are drawn here
ALL = "all problems"

Panels = dict[str, list[str]]  # the problems of each panel, by its title


class Measured(NamedTuple):
    """The final values of all runs on an axis that all panels share.

    Attributes:
        frame: the runs with a column ``value``, missing for a failed one.
        axis: the name of the axis.
        meaning: a sentence on it.
        logarithmic: whether the axis is.
    """

    frame: pd.DataFrame
    axis: str
    meaning: str
    logarithmic: bool


def panels(trials: Trials) -> Panels:
    """Return a panel for each problem; of more than :data:`MOST` problems one for each function, or for each class."""
    if len(trials.problems) <= MOST:
        return {label: [label] for label in trials.problems}
    by_function = _grouped(trials, "function")
    return by_function if 1 < len(by_function) <= MOST else classes(trials)


def classes(trials: Trials) -> Panels:
    """Return the problems of each class: a group of functions, else a suite, else a dimension; at most a few."""
    for feature in ("group", "suite"):
        found = _grouped(trials, feature)
        if 1 < len(found) <= MOST:
            return found
    found = {}
    for label in trials.problems:
        found.setdefault(f"d = {trials.dimensions[label]}" if label in trials.dimensions else ALL, []).append(label)
    return found if len(found) <= MOST else {ALL: list(trials.problems)}


def _grouped(trials: Trials, feature: str) -> Panels:
    """Return the problems by a feature, which of several suites stands behind the suite's name."""
    features = {label: trials.known[label].features for label in trials.problems}
    suites = {str(own.get("suite", "")) for own in features.values()}
    found: Panels = {}
    for label, own in features.items():
        name = str(own.get(feature, ALL))
        several = len(suites) > 1 and feature != "suite" and "suite" in own
        found.setdefault(f"{own['suite']} {name}" if several else name, []).append(label)
    return found


def measured(findings: Findings) -> Measured:
    """Return all final values on one kind of axis.

    It is the precision where that means something and is known on every problem, else the ratio to the lowest value
    known, or the distance from it, in units of that value or of the median run.
    """
    trials = findings.trials
    frame = trials.frame
    fun = scores(frame).where(lambda values: np.isfinite(values))
    problem = frame["problem"].astype(object)
    optimum = {label: 0.0 if label in trials.precisions else trials.unbeaten.get(label) for label in trials.problems}
    if findings.anytime.target_set.absolute and all(value is not None for value in optimum.values()):
        value = (fun - problem.map(optimum).astype(float)).clip(lower=SOLVED)
        meaning = f"The axis has the precision, the value less the optimum; one below {SOLVED:g} is drawn there."
        return Measured(frame.assign(value=value), "precision", meaning, True)
    lowest = fun.groupby(problem).min()
    best = problem.map(lowest if not optimum else lowest.combine(pd.Series(optimum, dtype=float), np.fmin)).astype(
        float
    )
    if bool((best.dropna() > 0).all()):
        scale, unit = best, "the lowest known"
    else:
        median = problem.map((fun - best).groupby(problem).median())
        scale, unit = median.where(median > 0, 1.0), "that of the median run"
    distance = (fun - best) / scale
    if unit == "the lowest known" and distance.max() < NARROW:
        meaning = "The axis has the value over the lowest that is known of the problem."
        return Measured(frame.assign(value=1 + distance), "value / lowest", meaning, False)
    over = "that value" if unit == "the lowest known" else unit
    meaning = f"The axis has the distance from the lowest value known, over {over}, from {FLOOR:g} on."
    return Measured(frame.assign(value=distance.clip(lower=FLOOR)), "distance from the lowest", meaning, True)
