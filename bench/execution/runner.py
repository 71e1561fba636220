"""Run a study's missing trials on a pool of workers and commit each as it finishes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from bench.execution import supervisor
from bench.execution.backends import open_pool
from bench.execution.interrupts import Interrupts, interrupts_deferred
from bench.execution.plan import Plan, Shard
from bench.execution.pool import Answer
from bench.execution.supervisor import Task
from bench.numbers import require_positive, require_whole
from bench.storage import provenance
from bench.storage.folder import Folder
from bench.study import Fingerprints, Study
from bench.trial import Trial

Listener = Callable[[Trial, dict[str, Any]], None]


@dataclass(frozen=True)
class Outcome:
    """The outcome of a run: its folder, the trials that it made, and the trials of the study that failed."""

    folder: Path
    made: int
    failed: int


def run(
    study: Study | str | PathLike[str],
    output: str | PathLike[str] | None = None,
    *,
    n_jobs: int = -1,
    backend: str = "loky",
    scheduler: str | None = None,
    timeout: float | None = None,
    memory: float | None = None,
    shard: str | None = None,
    on_plan: Callable[[Plan], None] | None = None,
    on_trial: Listener | None = None,
) -> Outcome:
    """Run every trial of a study that its folder does not hold yet.

    Rerunning the same call continues where the last one ended; failed trials are tried again. Results depend on the
    study alone: not on the number of workers, on the order of trials or on the other optimizers. Every trial is made
    in a process of the worker's own, so that an optimizer that hangs or crashes costs only its own trials.

    Args:
        study: a study, the name of an installed one, or a TOML file's path.
        output: the folder to write, ``results/runs/<study name>`` by default.
        n_jobs: worker processes; -1 takes every core. Not used with dask, whose workers are the cluster's.
        backend: where trials are made, "loky" (this machine) or "dask" (a cluster).
        scheduler: the address of dask's scheduler, such as "tcp://10.0.0.1:8786".
        timeout: wall seconds that a trial may take before it is stopped.
        memory: gigabytes that a trial's process may hold; by default an equal share of 90% of the machine's memory.
        shard: "3/20" for the third of twenty parts; each part is run into a folder of its own.
        on_plan: called once with the plan, before the first trial.
        on_trial: called with every finished trial and its row.

    Raises:
        BenchError: for a study that cannot be run or a folder that cannot take it.
        WorkerDiedError: when workers are killed several times in a row, or a cluster is lost.
        KeyboardInterrupt: on Ctrl-C, once what has finished is committed.
    """
    _check_limits(n_jobs, timeout, memory)
    study, folder, part = _resolved(study, output, shard)
    with interrupts_deferred() as interrupts, ExitStack() as held:
        with interrupts.allowed():  # loading plug-ins or reaching a cluster may take long
            held.callback(supervisor.close)
            found = prepare(study, folder, keep=n_jobs == 1)
            pool = held.enter_context(open_pool(backend, n_jobs, scheduler))
        held.enter_context(folder.lock())
        study = folder.claim(study)
        folder.note_fingerprints(found)
        plan = _plan(study, folder, part)
        if on_plan is not None:
            on_plan(plan)
        about = provenance.run(study, found, pool.jobs, backend, timeout=timeout, shard=shard)
        task = Task(study.to_toml(), timeout, _bytes(memory, pool.jobs, backend))
        made = _make(plan, folder, pool.answers(task, plan.missing), about, interrupts, on_trial)
        return Outcome(folder.path, made, sum(cell.failed for cell in folder.store.cells()))


def plan(
    study: Study | str | PathLike[str], output: str | PathLike[str] | None = None, *, shard: str | None = None
) -> Plan:
    """Return the plan of :func:`run`, and write nothing; raises BenchError as it does."""
    study, folder, part = _resolved(study, output, shard)
    prepare(study, folder)
    return _plan(folder.extended(study), folder, part)


def prepare(study: Study, folder: Folder, *, keep: bool = False) -> Fingerprints:
    """Load a study's plug-ins and return the fingerprints of its data and code, which must be those of its folder.

    With ``keep``, the process that loaded the plug-ins is kept for trials made here (:func:`supervisor.check`).

    Raises:
        BenchError: for a study that cannot be run, and a folder that holds another study, other data or other code.
    """
    folder.extended(study)
    found = supervisor.check(Task(study.to_toml()), keep=keep)
    folder.refuse_changes(found)
    return found


def _resolved(
    study: Study | str | PathLike[str], output: str | PathLike[str] | None, shard: str | None
) -> tuple[Study, Folder, Shard | None]:
    part = None if shard is None else Shard.parse(shard)
    study = study if isinstance(study, Study) else Study.load(study)
    return study, Folder(Path("results") / "runs" / study.name if output is None else output), part


def _plan(study: Study, folder: Folder, shard: Shard | None) -> Plan:
    """Return the plan of a study in its folder, with a note on what changed in the environment since its last run."""
    notes = []
    if changed := folder.differences(provenance.machine()):
        notes.append(
            f"the trials in {folder.path} were made by another environment ({'; '.join(changed)}): new trials may "
            "differ in their last digits and their times; the report lists them separately"
        )
    return Plan(study, shard, folder.store.keys(finished_only=True), folder.store.cells(), notes)


def _make(
    plan: Plan,
    folder: Folder,
    answers: Iterator[Answer],
    about: dict[str, Any],
    interrupts: Interrupts,
    on_trial: Listener | None,
) -> int:
    """Commit the missing trials as they are made; return their number."""
    numbers: dict[str, int] = {}  # of environments, by the machine's record
    made = 0
    with folder.store.writer() as writer:
        try:
            while True:
                with interrupts.allowed():
                    answer = next(answers, None)
                if answer is None:
                    return made
                trial, row, machine = answer
                if machine not in numbers:
                    numbers[machine] = writer.environment(json.loads(machine) | about)
                    folder.write_environments()
                writer.add(trial, row, numbers[machine])
                plan.finished.add(*trial.key)
                made += 1
                if on_trial is not None:
                    on_trial(trial, row)
        finally:
            answers.close()  # type: ignore[attr-defined]
            ended = provenance.now()
            for machine, number in numbers.items():
                writer.change(number, json.loads(machine) | about | {"ended": ended})
            if numbers:
                folder.write_environments()


def _check_limits(n_jobs: object, timeout: object, memory: object) -> None:
    if n_jobs != -1:
        require_whole("the number of jobs", n_jobs, 1, also=", or -1 for every core")
    for name, value, unit in (("timeout", timeout, "seconds"), ("memory", memory, "gigabytes")):
        if value is not None:
            require_positive(f"the {name} of a trial", value, unit=unit)


def _bytes(memory: float | None, jobs: int, backend: str) -> int | None:
    """Return the bytes of memory that one trial's process may hold, None for a cluster: its workers set limits."""
    if memory is not None:
        return int(memory * 1e9)
    return int(0.9 * provenance.memory() / jobs) if backend == "loky" else None
