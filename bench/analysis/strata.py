"""The strata of a problem: the trials of its pooled instances, which are compared instance by instance.

A difference between instances is no difference between optimizers. Where it is large it hides theirs if trials are
compared across instances; within an instance it is the same for all.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.analysis.cells import labels, scores
from bench.contract.typing import Floats

Samples = Sequence[Floats]  # of k optimizers, empty where one has no trial
Places = Sequence[NDArray[np.intp]]  # of the rows of each of them in a frame
FEWEST = 2  # trials of every optimizer on every instance; with fewer a stratum has no variance


def strata(frame: pd.DataFrame) -> dict[str, list[Samples]]:
    """Return the scores of each problem by stratum and optimizer (:func:`rows`), near-ties as ties."""
    values = np.asarray(scores(frame, merge=True), dtype=np.float64)
    return {label: [[values[cell] for cell in group] for group in groups] for label, groups in rows(frame).items()}


def rows(frame: pd.DataFrame) -> dict[str, list[Places]]:
    """Return the places of the rows of each problem by stratum and optimizer, in the order of trials.

    Instances are strata where every optimizer that has trials on the problem has two or more on each of them. Else all
    trials are one stratum: to compare them across instances that all optimizers share makes a test needlessly
    conservative, but never wrong more often.
    """
    problems, optimizers = labels(frame, "problem"), labels(frame, "optimizer")
    problem, optimizer = (
        pd.Categorical(frame[name].astype(object), names).codes
        for name, names in (("problem", problems), ("optimizer", optimizers))
    )
    instance = pd.factorize(frame["instance"])[0] if "instance" in frame else np.full(len(frame), -1)
    found: dict[str, list[Places]] = {}
    for place, label in enumerate(problems):
        own = np.flatnonzero(problem == place)
        cells = [own[optimizer[own] == one] for one in range(len(optimizers))]
        groups = [cells]
        numbers = np.unique(instance[own])
        if len(numbers) > 1:
            apart = [[cell[instance[cell] == number] for cell in cells] for number in numbers]
            if all(len(few) >= FEWEST for group in apart for few, cell in zip(group, cells, strict=True) if len(cell)):
                groups = apart
        found[label] = list(groups)
    return found
