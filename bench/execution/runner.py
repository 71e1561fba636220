"""Run a study's missing trials on a pool of workers and commit each as it finishes."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any

from joblib import cpu_count

from bench.errors import BenchError
from bench.execution import open_files
from bench.execution.again import Repetition, doubtful
from bench.execution.backends import open_pool
from bench.execution.job import Task
from bench.execution.local import Answer
from bench.execution.plan import Plan, Shard
from bench.execution.supervisor import Loaded, check
from bench.helpers.console import duration
from bench.helpers.text import count
from bench.numbers import require_jobs, require_positive
from bench.plugins import loading
from bench.plugins.inputs import Present, large, shown
from bench.sandbox.signals import Interrupts, interrupts_deferred
from bench.storage import provenance
from bench.storage.folder import DESCRIPTIONS, Folder, default_path, difference_line
from bench.storage.merge import Reusable, reusable, take
from bench.storage.selection import Selection
from bench.study import Study
from bench.trial import Trial

StudyLike = Study | Mapping[str, object] | str | PathLike[str]
Listener = Callable[[Trial, dict[str, Any]], None]


@dataclass(frozen=True)
class Outcome:
    """The outcome of a run.

    Attributes:
        folder: the study's folder.
        made: the trials that this run made.
        failed: the trials of the study that failed.
        undeclared: the trials of the study, by optimizer, that ended before the budget and did not declare why.
        different: a line for each trial that differed when it was made again at the end.
        edited: what was changed during the run, by name, with the number of trials that were made after that, and are
            another version.
        unasked: the optimizers that took none of the points that are known (``initial``).
        replayed: evaluations that the journals of interrupted trials answered.
        dropped: evaluations in journals that were of no use, as other points were asked for.
        doubtful: a line for each cell that gets no more trials, as a stored one differed when it was made again.
        spared: the optimizers of which trials were not considered for being made again, as their evaluations take long.
    """

    folder: Path
    made: int
    failed: int
    undeclared: dict[str, int]
    different: list[str]
    edited: dict[str, int]
    spared: list[str]
    doubtful: list[str]
    unasked: list[str]
    replayed: int = 0
    dropped: int = 0

    @property
    def remedy(self) -> str:
        """What to do where stored trials differ, in a sentence."""
        return (
            f"nothing was added to {count(len(self.doubtful), 'cell')}, as a stored trial of each differs when it is "
            "made again: something changed that no process was seen to read, such as a library of the system or a file "
            "that C code opens; put it back, or remove the old trials and run again ('bench rm "
            f"{self.folder} --optimizer NAME'), or give another --output"
        )


def run(
    study: StudyLike,
    output: str | PathLike[str] | None = None,
    *,
    n_jobs: int = -1,
    backend: str = "local",
    scheduler: str | None = None,
    timeout: float | None = None,
    memory: float | None = None,
    shard: str | None = None,
    untrusted: bool = False,
    verify: bool = True,
    reuse: Sequence[str | PathLike[str]] = (),
    on_plan: Callable[[Plan], None] | None = None,
    on_trial: Listener | None = None,
    progress: bool | None = None,
) -> Outcome:
    """Run every trial of a study that its folder does not hold yet.

    Rerunning the same call continues where the last one ended; failed trials are tried again. Results depend on the
    study alone: not on the number of jobs, on the order of trials or on the other optimizers. Every optimizer runs in
    processes of its own, so that one that hangs or crashes costs only its own trials.

    Args:
        study: a study, a dict of what its file would hold, the name of an installed one, or a TOML file's path.
        output: the folder to write, ``results/runs/<study name>`` by default.
        n_jobs: trials made at a time; -1 takes every core. Not used with dask, whose workers are the cluster's.
        backend: where trials are made, "local" (this machine) or "dask" (a cluster).
        scheduler: the address of dask's scheduler, such as "tcp://10.0.0.1:8786".
        timeout: wall seconds that a trial may take before it is stopped.
        memory: gigabytes that a trial's process may hold; by default an equal share of 90% of the machine's memory.
        untrusted: keep problem, budget and trace of every trial in another process than its optimizer, run all
            plug-ins in a sandbox of bubblewrap (Linux), and limit a trial to 10 minutes and 4 GB where no other limits
            are given.
        verify: make one trial of each optimizer again at the end, in a fresh process, and note in the folder those that
            differ (:mod:`bench.execution.again`).
        reuse: folders whose trials of equal cells are taken instead of being made again.
        shard: "3/20" for the third of twenty parts; each part is run into a folder of its own.
        on_plan: called once with the plan, before the first trial.
        on_trial: called with every finished trial and its row.
        progress: whether to print the plan, the trials done and the failures; by default in a notebook only.

    Raises:
        BenchError: for a study that cannot be run or a folder that cannot take it.
        WorkerDiedError: when workers are killed several times in a row, or a cluster is lost.
        KeyboardInterrupt: on Ctrl-C, once what has finished is committed.
    """
    from bench.execution.progress import displayed  # not at the top: it imports rich

    _check_limits(n_jobs, timeout, memory)
    study, folder, part = _resolved(study, output, shard)
    others = [Folder(path) for path in reuse]
    with interrupts_deferred() as interrupts, ExitStack() as held:
        with interrupts.allowed():  # loading plug-ins or reaching a cluster may take long
            checked = prepare(study, folder, untrusted)
            _, selection = folder.select(study, checked.dimensions, checked.present)
            reused = _reusable(folder, selection, others, checked.present)
            pool = held.enter_context(open_pool(backend, n_jobs, scheduler))
            kept = open_files.kept(pool.jobs) if backend == "local" else open_files.KEPT
        under_way = held.enter_context(folder.lock())
        folder.note_store(folder.require_sound())
        study, selection = folder.select(study, checked.dimensions, checked.present)
        folder.claim(study, selection)
        folder.note_selected(study)
        for other, found in zip(others, _reusable(folder, selection, others, checked.present), strict=True):
            with folder.store.writer() as writer:
                take(other, writer, found.cells, where=other.path.name)
        beside = at_a_time(study, pool.jobs, backend)
        plan = _plan(study, folder, part, selection, [*(found.sentence for found in reused), beside], verify)
        display = held.enter_context(displayed(progress))
        if display is not None:
            display.within.folder = folder.path
            display.plan(plan)
        if on_plan is not None:
            on_plan(plan)
        held_bytes = _bytes(memory, pool.jobs, backend)
        task = replace(checked.task, study=study, timeout=timeout, memory=held_bytes, kept=kept)
        about = provenance.run(study, pool.jobs, backend, timeout=task.timeout, shard=shard, untrusted=untrusted)
        listeners = ([] if display is None else [display.trial]) + ([] if on_trial is None else [on_trial])

        def make(missing: Callable[[], Iterable[Trial]]) -> Iterator[Answer]:
            return pool.answers(task, checked.machine, missing, under_way.begin)

        with interrupts.allowed():
            doubted = doubtful(plan, folder, make)
        plan.doubtful.update(trial.key[:2] for trial in doubted)
        repetition = Repetition(study)
        made, edited, unasked, replay = _make(
            plan, folder, make(plan.missing), about, interrupts, repetition, listeners
        )
        if not (counted := folder.store.check_count()).sound:
            raise BenchError(f"the store {folder.store.path} was changed while the run wrote to it: {counted.sentence}")
        folder.note(DESCRIPTIONS, {label: asdict(each) for label, each in checked.descriptions.items()})
        with interrupts.allowed():
            different = repetition.make(folder, make) if verify else []
        failed = sum(cell.failed for cell in folder.store.cells())
        spared = sorted(repetition.expensive) if verify else []
        doubts = [difference_line(trial, what) for trial, what in doubted.items()]
        return Outcome(
            folder.path, made, failed, folder.store.undeclared(), different, edited, spared, doubts, unasked, *replay
        )


def plan(
    study: StudyLike,
    output: str | PathLike[str] | None = None,
    *,
    shard: str | None = None,
    untrusted: bool = False,
    verify: bool = True,
    reuse: Sequence[str | PathLike[str]] = (),
) -> Plan:
    """Return the plan of :func:`run`, and write nothing; raises BenchError as it does."""
    study, folder, part = _resolved(study, output, shard)
    folder.require_sound()
    checked = prepare(study, folder, untrusted)
    others = [Folder(path) for path in reuse]
    study, selection = folder.select(study, checked.dimensions, checked.present)
    reused = _reusable(folder, selection, others, checked.present)
    plan = _plan(study, folder, part, selection, [found.sentence for found in reused], verify)
    labels = {cell: labels for labels, cell in selection.cells.items()}
    for other, found in zip(others, reused, strict=True):
        numbers = {number: cell for number, cell in other.store.held().all.items() if cell in found.cells}
        shown = {number: labels[found.cells[cell]] for number, cell in numbers.items()}
        plan.finished.update(other.store.keys(finished_only=True, shown=shown))
    return plan


def prepare(study: Study, folder: Folder, untrusted: bool = False) -> Loaded:
    """Load a study's plug-ins; raises BenchError for a study that cannot be run, or not without a sandbox."""
    if study.imported:
        raise BenchError(
            f"study {study.name!r} holds imported trials, such as those of {study.imported[0]}, and no optimizer that "
            "could make or repeat them"
        )
    foreign = [entry.name for entry in (*study.problems, *study.optimizers) if loading.brings_code(entry.name)]
    if foreign and folder.untrusted and not untrusted:
        raise BenchError(
            f"{folder.path} comes from an archive, or was made with --untrusted, and names {foreign[0]!r}, whose code "
            "nobody trusts: add --untrusted"
        )
    known = large(folder.store.held().made.values())
    return check(replace(Task.of(study, untrusted), output=str(folder.path.absolute()), known=known))


def _resolved(
    study: StudyLike, output: str | PathLike[str] | None, shard: str | None
) -> tuple[Study, Folder, Shard | None]:
    part = None if shard is None else Shard.parse(shard)
    study = study if isinstance(study, Study) else Study.load(study)
    study.require_sound()
    return study, Folder(default_path(study) if output is None else output), part


def _plan(
    study: Study, folder: Folder, shard: Shard | None, selection: Selection, found: Iterable[str], verify: bool
) -> Plan:
    """Return the plan of a study in its folder; its notes are what was found, and what changed since the last run."""
    notes = [note for note in (*found, *selection.notes) if note]
    if changed := folder.differences(provenance.machine()):
        notes.append(
            f"the trials in {folder.path} were made by another environment ({'; '.join(changed)}): new trials may "
            "differ in their last digits and their times; the report lists them separately"
        )
    if study.time is not None:
        notes.append(
            f"a trial ends after {duration(study.time)}, whatever it has evaluated by then: where that comes before "
            "the budget, it cannot be repeated bit by bit, and a faster or less busy machine gives other results"
        )
    if study.evaluation_timeout is not None:
        notes.append(
            f"a point fails after {duration(study.evaluation_timeout)}: a trial in which one did depends on the "
            "machine and is not made again"
        )
    store = folder.store
    shown = selection.labels_in(store.held())
    finished = store.keys(finished_only=True, shown=shown)
    return Plan(study, shard, finished, store.cells(shown), notes, selection.seeds, verify=verify)


def _reusable(folder: Folder, selection: Selection, others: Sequence[Folder], present: Present) -> list[Reusable]:
    """Return what other folders hold of a selection's cells; raises BenchError as :func:`reusable`."""
    if any(other.path.resolve() == folder.path.resolve() for other in others):
        raise BenchError(f"{folder.path} is the folder to write; leave it out of what is reused")
    return [reusable(other, selection.cells, present) for other in others]


def _make(
    plan: Plan,
    folder: Folder,
    answers: Iterator[Answer],
    about: dict[str, Any],
    interrupts: Interrupts,
    repetition: Repetition,
    listeners: Sequence[Listener],
) -> tuple[int, dict[str, int], list[str], list[int]]:
    """Commit the missing trials as they are made; return of an Outcome ``made``, ``edited``, ``unasked`` and more."""
    numbers: dict[str, int] = {}  # of environments, by the machine's record
    made, edited, unasked, replay = 0, Counter[str](), dict[str, None](), [0, 0]
    with folder.store.writer() as writer:
        try:
            while True:
                with interrupts.allowed():
                    answer = next(answers, None)
                if answer is None:
                    return made, dict(edited), [*unasked], replay
                trial, row, machine = answer
                if machine not in numbers:
                    numbers[machine] = writer.environment(json.loads(machine) | about)
                    folder.write_environments()
                made_from, after = row.pop("inputs", None), row.pop("after", 0)
                replay = [sum(pair) for pair in zip(replay, row.pop("journal", None) or (0, 0), strict=True)]
                if row.pop("unasked", False):
                    unasked[trial.optimizer] = None
                if others := writer.conflicts(trial, made_from):
                    edited.update(map(shown, others))
                else:
                    repetition.consider(trial, row, after)
                writer.add(trial, row, numbers[machine], made_from)
                plan.finished.add(trial.key)
                made += 1
                for listener in listeners:
                    listener(trial, row)
        finally:
            answers.close()  # type: ignore[attr-defined]
            ended = provenance.now()
            for machine, number in numbers.items():
                writer.change(number, json.loads(machine) | about | {"ended": ended})
            if numbers:
                folder.write_environments()


def at_a_time(study: Study, jobs: int, backend: str = "local") -> str:
    """Return in a sentence how many evaluations are made at a time beside the cores there are; "" with one a job."""
    if study.parallel == 1:
        return ""
    cores = f" on {count(int(cpu_count()), 'core')}" if backend == "local" else ""
    return (
        f"{count(jobs, 'job')} x {study.parallel} points in parallel: up to {jobs * study.parallel:,} evaluations at a "
        f"time{cores}"
    )


def _check_limits(jobs: object, timeout: object, memory: object) -> None:
    require_jobs("the number of jobs", jobs)
    for name, value, unit in (("timeout", timeout, "seconds"), ("memory", memory, "gigabytes")):
        if value is not None:
            require_positive(f"the {name} of a trial", value, unit=unit)


def _bytes(memory: float | None, jobs: int, backend: str) -> int | None:
    """Return the bytes of memory that one trial's process may hold, None for a cluster: its workers set limits."""
    if memory is not None:
        return int(memory * 1e9)
    return int(0.9 * provenance.memory() / jobs) if backend == "local" else None
