"""Choose disjoint training and test problems, and write the study that tests the tuned parameters."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import Any

import numpy as np

from bench.errors import BenchError, nearest
from bench.plugins import loading, selection
from bench.problem import Problem
from bench.seeds import trial_seed
from bench.study import Study
from bench.study.tuned import Tuning
from bench.tuning.tune import Best, TuningSetup


def split(train: Sequence[str], test: Sequence[str], leave_out: str | None, seed: int) -> tuple[list[str], list[str]]:
    """Return the names of the training problems, in a random order, and of the test problems.

    With ``leave_out``, the problems of ``train`` whose functions are of that group become the test problems.

    Raises:
        BenchError: where one of both is empty, or a problem, or its data, is in both; and for an unknown group.
    """
    training, testing = ([name for glob in patterns for name in selection.matching(glob)] for patterns in (train, test))
    if leave_out is not None:
        if testing:
            raise BenchError("give either --test or --leave-out: a group that is left out is what the test runs on")
        groups = {name: str(loading.load_problem(name).features.get("group", "")) for name in training}
        all_groups = {group for group in groups.values() if group}
        if leave_out not in all_groups:
            raise BenchError(f"no training problem is of the group {leave_out!r}{nearest(leave_out, all_groups)}")
        testing = [name for name in training if groups[name] == leave_out]
        training = [name for name in training if groups[name] != leave_out]
    training, testing = list(dict.fromkeys(training)), list(dict.fromkeys(testing))
    for kind, names in (("training", training), ("test", testing)):
        if not names:
            raise BenchError(f"tuning needs at least one {kind} problem beside the others; name more of them")
    if both := [name for name in training if name in testing]:
        raise BenchError(
            f"{both[0]!r} is a training and a test problem; what is tuned on a problem must be tested on another one"
        )
    _refuse_equal_data(training, testing)
    order = np.random.default_rng(trial_seed(seed, "tuning", "order", 0)).permutation(len(training))
    return [training[place] for place in order], testing


def _refuse_equal_data(training: Sequence[str], testing: Sequence[str]) -> None:
    trained_on = {fingerprint: name for name in training if (fingerprint := loading.load_problem(name).fingerprint())}
    for name in testing:
        if trained := trained_on.get(loading.load_problem(name).fingerprint()):
            raise BenchError(f"{trained!r} and {name!r} have the same data; train and test on different data")


def load(names: Sequence[str]) -> dict[str, Problem]:
    """Return the training problems by name; raises BenchError for one whose optimum is unknown."""
    problems = {name: loading.load_problem(name) for name in names}
    for name, problem in problems.items():
        if problem.optimum is None or not isfinite(problem.optimum):
            raise BenchError(
                f"the optimum of {name!r} is unknown, so no regret can be measured; train on other problems"
            )
    return problems


def untuned(name: str, test: Sequence[str], optimizers: Sequence[str], setting: TuningSetup) -> Study:
    """Return the study of the defaults; raises BenchError for what cannot be run, before anything is tuned."""
    entries = [{"name": optimizer, **setting.fixed} for optimizer in optimizers]
    study = Study.from_dict(_head(name, test, setting) | {"optimizers": entries}, repr(name))
    study.data()
    return study


def tuned(name: str, test: Sequence[str], bests: Sequence[Best], setting: TuningSetup, **about: str) -> Study:
    """Return the study that runs the defaults and the best configuration of each optimizer on the test problems.

    ``about`` holds ``left_out`` and ``method`` of :class:`bench.study.tuned.Tuning`.
    """
    entries: list[dict[str, Any]] = []
    for best in bests:
        entries.append({"name": best.record.name, **setting.fixed})
        if best.options:
            entries.append({"name": best.record.name, "label": best.record.tuned, **setting.fixed, **best.options})
    record = Tuning(
        setting.objective, setting.trials, setting.runs, setting.budget, setting.seed, list(setting.train),
        optimizers=tuple(best.record for best in bests), **about,
    )  # fmt: skip
    return Study.from_dict(_head(name, test, setting) | {"optimizers": entries, "tuning": record.sealed()}, repr(name))


def _head(name: str, test: Sequence[str], setting: TuningSetup) -> dict[str, Any]:
    return {
        "name": name, "title": "Default and tuned parameters", "seed": setting.seed,
        "budget": setting.budget, "problems": [{"names": list(test)}],
    }  # fmt: skip
