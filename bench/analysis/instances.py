"""Pool the instances of a function: a cell is then (function, dimension) and optimizer, over instances and trials.

That is how COCO compares (Hansen, Auger, Ros, Mersmann, Tušar and Brockhoff 2021, Optimization Methods and Software
36). Instances have different optima, so what is compared is the precision f - f_opt.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from bench.analysis.cells import BEATEN, Traces
from bench.contract.objective import Trace

SOLVED = 1e-8
"""The last target of COCO, below which the CEC competitions take an error as 0 too; a better precision is rounding."""

Features = Mapping[str, Mapping[str, str | int]]  # of problems, by label


@dataclass(frozen=True)
class Pooled:
    """The trials of a study with instances pooled.

    Attributes:
        frame: the tidy frame; pooled trials have their function as problem, numbers that do not repeat, their
            ``instance``, and the precision as ``fun``, 0 where it is at most 1e-8.
        traces: their traces, likewise.
        members: the labels of the problems that each problem of the frame stands for, in their order.
    """

    frame: pd.DataFrame
    traces: Traces
    members: dict[str, list[str]]

    @property
    def functions(self) -> list[str]:
        """The problems of the frame whose values are precisions."""
        return [label for label, instances in self.members.items() if instances != [label]]


def pool_instances(
    frame: pd.DataFrame, traces: Traces, problems: Iterable[str], features: Features, optima: Mapping[str, float]
) -> Pooled:
    """Pool the instances of each function and dimension.

    A problem takes part where its ``features`` have an instance, its label ends with it (``bbob-f08-d5-i1``), its
    optimum is known, and no trial beat it by more than rounding. One instance alone stays as it is.

    Args:
        frame: the tidy frame.
        traces: of its trials.
        problems: the labels, in the study's order.
        features: of the problems, by label.
        optima: the known optima, by label.
    """
    values = pd.to_numeric(frame["fun"], errors="coerce").astype(float)
    lowest = values.groupby(frame["problem"].astype(object)).min()
    groups: dict[str, list[str]] = {}
    for label in problems:
        function = label.removesuffix(f"-i{features.get(label, {}).get('instance')}")
        least = optima[label] - max(SOLVED, BEATEN * abs(optima[label])) if label in optima else np.inf
        groups.setdefault(function if lowest.get(label, np.inf) >= least else label, []).append(label)
    pools = {function: instances for function, instances in groups.items() if len(instances) > 1}
    function_of = {label: function for function, instances in pools.items() for label in instances}
    members = {function_of.get(label, label): pools.get(function_of.get(label, label), [label]) for label in problems}
    if not pools:
        return Pooled(frame, traces, members)
    trials = int(frame["trial"].max()) + 1 if len(frame) else 1
    offset = {label: trials * number for instances in pools.values() for number, label in enumerate(instances)}
    problem = frame["problem"].astype(object)
    above = values - problem.map(optima).astype(float)
    changed = frame.assign(
        problem=problem.map(function_of).fillna(problem),
        trial=frame["trial"] + problem.map(offset).fillna(0).astype(int),
        fun=values.where(~problem.isin(function_of), above.mask(above <= SOLVED, 0.0)),
        instance=problem.map({label: features[label]["instance"] for label in function_of}),
    )
    moved = _Precisions(traces, pools, offset, optima, trials)
    return Pooled(changed, moved, members)


@dataclass(frozen=True)
class _Precisions(Mapping[tuple[str, str, int], Trace]):
    """The traces of pooled trials, each computed when it is asked for: copies of all would double their memory.

    Attributes:
        traces: the traces of the trials before they were pooled.
        pools: the instances of each function that was pooled, by label.
        offset: what was added to the numbers of an instance's trials.
        optima: the known optimum of each instance.
        trials: the largest number of trials of an instance.
    """

    traces: Traces
    pools: Mapping[str, Sequence[str]]
    offset: Mapping[str, int]
    optima: Mapping[str, float]
    trials: int

    def __getitem__(self, key: tuple[str, str, int]) -> Trace:
        problem, optimizer, trial = key
        if problem not in self.pools:
            return self.traces[key]
        number, trial_of_instance = divmod(trial, self.trials)
        if number >= len(self.pools[problem]):
            raise KeyError(key)
        instance = self.pools[problem][number]
        return _above(self.traces[instance, optimizer, trial_of_instance], self.optima[instance])

    def __iter__(self) -> Iterator[tuple[str, str, int]]:
        function_of = {label: function for function, instances in self.pools.items() for label in instances}
        for problem, optimizer, trial in self.traces:
            yield function_of.get(problem, problem), optimizer, trial + self.offset.get(problem, 0)

    def __len__(self) -> int:
        return len(self.traces)


def _above(trace: Trace, optimum: float) -> Trace:
    """Return the trace of precisions, which ends where the last target is reached."""
    values = trace.values - optimum
    values[values <= SOLVED] = 0.0
    new = values[1:] < values[:-1]  # rounding may make neighbours equal
    if new.all():
        return Trace(trace.evaluations, values)
    new = np.append(True, new)
    return Trace(trace.evaluations[new], values[new])
