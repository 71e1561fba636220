"""Run a study's missing trials with joblib and commit each as it finishes."""

from __future__ import annotations

import random
import tomllib
import traceback
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from os import PathLike
from pathlib import Path
from typing import Any

from joblib import Parallel, cpu_count, delayed, parallel_config
from joblib.externals.loky.process_executor import BrokenProcessPool

from bench.errors import BenchError, nearest
from bench.folder import Folder
from bench.problem import Problem
from bench.study import Study, Trial
from bench.trial import as_row, solve

BACKENDS = ("loky",)

Listener = Callable[[Trial, dict[str, Any]], None]


class WorkerDiedError(RuntimeError):
    """A worker process ended in the middle of a trial; what was finished is kept."""


@dataclass(frozen=True)
class Outcome:
    """How a run ended: where its results are, how many trials it made, and how many of the study's failed."""

    folder: Path
    made: int
    failed: int


def run(
    study: Study | str | PathLike[str],
    output: str | PathLike[str] | None = None,
    *,
    n_jobs: int = -1,
    backend: str = "loky",
    on_plan: Callable[[Study, set[tuple[str, str, int]]], None] | None = None,
    on_trial: Listener | None = None,
) -> Outcome:
    """Run every trial of a study that its folder does not hold yet.

    Rerunning the same call continues where the last one ended; failed trials are tried again. Results depend on the
    study alone: not on the number of workers, on the order of trials or on the other optimizers.

    Args:
        study: a study, the name of an installed one, or a TOML file's path.
        output: the folder to write, ``results/runs/<study name>`` by default.
        n_jobs: worker processes; -1 takes every core.
        backend: a joblib backend, "loky".
        on_plan: called once with the study as frozen and the keys already done.
        on_trial: called with every finished trial and its row.

    Raises:
        BenchError: for a study that cannot be run or a folder that cannot take it.
        WorkerDiedError: when a worker process ends in the middle of a trial.
    """
    if isinstance(n_jobs, bool) or not isinstance(n_jobs, int) or n_jobs == 0 or n_jobs < -1:
        raise BenchError(f"the number of jobs must be at least 1, or -1 for every core, not {n_jobs!r}")
    if backend not in BACKENDS:
        raise BenchError(f"unknown backend {backend!r}{nearest(backend, BACKENDS)}")
    study = study if isinstance(study, Study) else Study.load(study)
    data, code = study.check()
    folder = Folder(output if output is not None else Path("results") / "runs" / study.name)
    study = folder.claim(study)
    with folder.lock():
        folder.check_data(data)
        folder.check_code(code)
        done = folder.store.keys(finished_only=True)
        if on_plan is not None:
            on_plan(study, done)
        missing = [trial for trial in study.plan() if trial.key not in done]
        # Interleaved in random order, so that a busy machine slows no one algorithm more than another.
        random.Random(study.seed).shuffle(missing)
        jobs = cpu_count() if n_jobs == -1 else n_jobs
        if missing:
            folder.note_environment(jobs)
        with folder.store.writer() as writer:
            for trial, row in _stream(study, missing, jobs, backend):
                writer.add(trial, row)
                if on_trial is not None:
                    on_trial(trial, row)
        failed = len(folder.store.keys()) - len(folder.store.keys(finished_only=True))
    return Outcome(folder.path, len(missing), failed)


def _stream(study: Study, trials: list[Trial], jobs: int, backend: str) -> Iterable[tuple[Trial, dict[str, Any]]]:
    """Yield (trial, row) as workers finish, in any order."""
    text = study.to_toml()  # a study's text is its pickle: workers load plug-ins by name, as the parent does
    with parallel_config(backend=backend, n_jobs=jobs, inner_max_num_threads=1):
        # One trial a task: a task is a tenth of a second or more, and a killed run then loses only those under way.
        parallel = Parallel(return_as="generator_unordered", batch_size=1, pre_dispatch="3*n_jobs")
        try:
            yield from parallel(delayed(_work)(text, trial) for trial in trials)
        except BrokenProcessPool as error:
            raise WorkerDiedError(
                "a worker process died (killed, out of memory, or ended by a plug-in); every finished trial is kept: "
                "run the same command again to continue"
            ) from error


def _work(study_text: str, trial: Trial) -> tuple[Trial, dict[str, Any]]:
    """Make one trial in a worker; whatever it raises becomes its row."""
    try:
        study = _study(study_text)
        problem, optimizer = _problem(study_text, trial.problem), study.optimizer(trial.optimizer)
        _warm_up(study_text, type(problem), trial.problem, trial.optimizer)
        result = solve(problem, optimizer, budget=study.budget, seed=trial.seed)
        return trial, as_row(result, problem.variables)
    except (Exception, SystemExit) as error:  # a plug-in may raise anything, and it costs only its own cell
        where = traceback.format_exc(limit=-3)
        return trial, {"status": "failed", "error": f"{type(error).__name__}: {error}\n{where}"}


@lru_cache(maxsize=4)
def _study(text: str) -> Study:
    return Study.from_dict(tomllib.loads(text))


@lru_cache(maxsize=256)
def _problem(study_text: str, label: str) -> Problem:
    return _study(study_text).problem(label)


_warm: set[tuple[str, type, str]] = set()


def _warm_up(study_text: str, kind: type, problem: str, optimizer: str) -> None:
    """Spend one discarded, short trial a worker, kind of problem and optimizer: no trial shall wait for a compiler."""
    if (study_text, kind, optimizer) in _warm:
        return
    _warm.add((study_text, kind, optimizer))
    study = _study(study_text)
    loaded = study.optimizer(optimizer)
    with suppress(Exception):  # the trial itself will say what is wrong
        solve(_problem(study_text, problem), loaded, budget=min(study.budget, 3 * loaded.minimum_budget))
