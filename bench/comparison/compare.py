"""Compare optimizers on problems from Python alone: names, objects, classes and functions, in one call."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from inspect import signature
from itertools import count as numbers
from os import PathLike
from pathlib import Path
from typing import Any

from bench.comparison.notebook import Results
from bench.execution.job import Task
from bench.execution.runner import Outcome, run
from bench.execution.supervisor import check
from bench.helpers.errors import BenchError
from bench.helpers.parsing import JsonObject
from bench.helpers.text import count, listed
from bench.plugins.loading import OptimizerLike, ProblemLike, is_plugin
from bench.storage.folder import Folder, default_path
from bench.study import Study
from bench.trial.trial import UNASKED

NAME = "comparison"
"""The name of the study, unless another one is given."""

Table = Mapping[str, object]
"""A table of a study's file, with ``name``, in whose place may be an object."""


def compare(
    problems: ProblemLike | Table | Iterable[ProblemLike | Table],
    optimizers: OptimizerLike | Table | Iterable[OptimizerLike | Table],
    *,
    trials: int = 15,
    budget: int | str | Mapping[str, int] = "1000 * d",
    seed: int = 0,
    output: str | PathLike[str] | None = None,
    n_jobs: int = -1,
    **study: object,
) -> Results:
    """Run optimizers on problems and return the results, which a notebook shows as a verdict with its table.

    The same call again makes the trials that are missing and no others. A function or a class that has changed
    meanwhile gets new trials, as the next version.

    Example:
        >>> valley = bench.FunctionProblem(lambda x: (x[0] - 1) ** 2 + 100 * (x[1] - x[0] ** 2) ** 2, [-2] * 2, [2] * 2)
        >>> bench.compare(valley, ["cma-es", "random-search", MyDE])

    Args:
        problems: one or more names, as a study's file has them, problems, or classes of them. A function is one with
            its bounds: ``bench.FunctionProblem(fun, lower, upper)``. A mapping gives each its label.
        optimizers: likewise names, optimizers, classes of them, functions ``(objective, rng)``, classes with ``ask``
            and ``tell``, or classes ``X(budget, dim)`` whose instances are called with the function.
        trials: runs of each optimizer on each problem.
        budget: evaluations that a run may spend.
        seed: from which the seeds of all trials derive.
        output: the folder to write; by default ``results/runs/comparison``, or ``comparison-2`` and so on where that
            has another comparison.
        n_jobs: trials made at a time; -1 takes every core.
        study: further keys of a study, such as ``constraints``, and further arguments of :func:`bench.run`, such as
            ``timeout``.

    Raises:
        BenchError: for an unknown problem, a study that cannot be run, where no optimizer can be loaded, and where no
            trial succeeds. An optimizer that cannot be loaded beside others that can is left out with a warning.
        WorkerDiedError: when workers are killed several times in a row.
        KeyboardInterrupt: on Ctrl-C, once what has finished is committed.
    """
    settings = {key: study.pop(key) for key in study.keys() & {*signature(run).parameters} - {"study"}}
    content: JsonObject = {
        "name": NAME, "trials": trials, "budget": budget, "seed": seed,
        "problems": _listed(problems), "optimizers": _listed(optimizers),
    }  # fmt: skip
    content |= study
    try:
        outcome = _ran(content, output, n_jobs=n_jobs, **settings)
    except BenchError:
        works, reasons = _that_load(content)
        if not works or not reasons:
            raise
        for reason in reasons:
            warnings.warn(reason, stacklevel=2)
        outcome = _ran(content | {"optimizers": works}, output, n_jobs=n_jobs, **settings)
    results = Results(outcome.folder)
    _report_losses(outcome, results)
    return results


def _ran(content: JsonObject, output: str | PathLike[str] | None, **settings: Any) -> Outcome:
    """Run the study of this content."""
    chosen = Study.from_dict(content, "to compare")
    return run(chosen, _place(chosen) if output is None else output, **settings)


def _that_load(content: JsonObject) -> tuple[list[object], list[str]]:
    """Return the optimizers that can be loaded beside the problems, and a sentence on each other one."""
    found, reasons = [], []
    for given in content["optimizers"]:
        try:
            check(Task.of(Study.from_dict({**content, "optimizers": [given]}, "to compare")))
        except BenchError as error:
            name = given.get("label", given.get("name")) if isinstance(given, Mapping) else given
            reasons.append(f"optimizer {getattr(name, '__name__', name)} is left out, as it cannot be loaded: {error}")
        else:
            found.append(given)
    return found, reasons


def _listed(given: object) -> list[object]:
    """Return one name, object or table, several, or a mapping by label, as a list."""
    if isinstance(given, Mapping):
        return [
            {**(thing if isinstance(thing, Mapping) else {"name": thing}), "label": label}
            for label, thing in given.items()
        ]
    if isinstance(given, str) or is_plugin(given) or not isinstance(given, Iterable):
        return [given]
    return list(given)


def _place(study: Study) -> Path:
    """Return the folder under ``results/runs`` that has this study already, else the next one that is free."""
    first = default_path(study)
    folders = (first.with_name(f"{first.name}-{number}" if number > 1 else first.name) for number in numbers(1))
    return next(folder for folder in folders if Folder(folder).store.held().study in ("", study.identity()))


def _report_losses(outcome: Outcome, results: Results) -> None:
    """Warn of failed trials and of those that are not repeated; raise BenchError where every trial failed."""
    frame = results.frame
    lost = frame[frame["status"] != "ok"]
    if len(lost):
        first = lost.iloc[0]
        reason = str(first["error"]).partition("\n")[0]
        example = f"{first['optimizer']} on {first['problem']}, trial {first['trial']}: {reason}"
        if len(lost) == len(frame):
            raise BenchError(f"every trial failed, the first one {example}")
        warnings.warn(f"{count(len(lost), 'trial')} of {len(frame):,} failed, such as {example}", stacklevel=3)
    if outcome.unasked:
        warnings.warn(UNASKED.format(listed(outcome.unasked)), stacklevel=3)
    for line in outcome.different:
        warnings.warn(f"a trial made again is another one; {line}", stacklevel=3)
    if outcome.doubtful:
        warnings.warn(f"{outcome.doubtful[0]}; {outcome.remedy}", stacklevel=3)
