"""Compare optimizers on problems from Python alone: names, objects, classes and functions, in one call."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from functools import cache
from inspect import signature
from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from bench.errors import BenchError
from bench.execution.runner import Outcome, run
from bench.helpers.text import count, listed, short_hash
from bench.notebook import Results
from bench.plugins import objects
from bench.plugins.objects import OptimizerLike, ProblemLike
from bench.study import Study
from bench.trial import UNASKED

NAME = "comparison"
"""The name of the study, unless another one is given."""

Table = Mapping[str, object]
"""What a table of a study's file would hold, with ``name``; in its place may be an object."""


def compare(
    problems: ProblemLike | Table | Iterable[ProblemLike | Table],
    optimizers: OptimizerLike | Table | Iterable[OptimizerLike | Table],
    *,
    trials: int = 15,
    budget: int | str | Mapping[str, int] = "100 * d",
    seed: int = 0,
    output: str | PathLike[str] | None = None,
    n_jobs: int = -1,
    **study: object,
) -> Results:
    """Run optimizers on problems and return the results, which a notebook shows as a verdict with its table.

    The same call again makes the trials that are missing and no others. Functions and classes may have changed
    meanwhile: trials of other code or data are other ones.

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
        output: the folder to write; by default a temporary one, which is kept while this session runs and by
            :meth:`bench.Results.save`.
        n_jobs: trials made at a time; -1 takes every core.
        study: further keys of a study, such as ``constraints``, and further arguments of :func:`bench.run`, such as
            ``timeout``.

    Raises:
        BenchError: for what is no problem or no optimizer, a study that cannot be run, and where no trial succeeds.
        WorkerDiedError: when workers are killed several times in a row.
        KeyboardInterrupt: on Ctrl-C, once what has finished is committed.
    """
    settings = {key: study.pop(key) for key in study.keys() & {*signature(run).parameters} - {"study"}}
    content = {
        "name": NAME, "trials": trials, "budget": budget, "seed": seed,
        "problems": _listed(problems), "optimizers": _listed(optimizers),
    }  # fmt: skip
    chosen = Study.from_dict(content | study, "to compare")
    folder = _temporary(chosen) if output is None else Path(output)
    outcome = run(chosen, folder, n_jobs=n_jobs, **settings)  # type: ignore[arg-type]
    results = Results(outcome.folder)
    _report_losses(outcome, results)
    return results


def _listed(given: Any) -> list[Any]:
    """Return one name, object or table, several, or a mapping by label, as a list."""
    if isinstance(given, Mapping):
        return [
            {**(thing if isinstance(thing, Mapping) else {"name": thing}), "label": label}
            for label, thing in given.items()
        ]
    if isinstance(given, str) or objects.is_plugin(given) or not isinstance(given, Iterable):
        return [given]
    return list(given)


def _temporary(study: Study) -> Path:
    """Return the folder of this session for a study of these objects, so that the same call continues it."""
    optimizers, problems = ([entry.name for entry in every] for every in (study.optimizers, study.problems))
    held = {key: each.digest for key, each in objects.among(optimizers, problems).items()}
    return Path(_place().name, short_hash(repr([study.identity(), held])), study.name)


@cache
def _place() -> TemporaryDirectory[str]:
    return TemporaryDirectory(prefix="bench-", ignore_cleanup_errors=True)  # removed when the session ends


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
