"""Run a study's missing trials: resolve it, select its cells in the folder, plan, make, commit, note."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from os import PathLike
from pathlib import Path

from joblib import cpu_count

from bench.contract.numbers import require_jobs, require_positive
from bench.execution.again import Repetition, doubtful
from bench.execution.dask import Cluster, cluster
from bench.execution.job import Task
from bench.execution.local import Answer, Local
from bench.execution.plan import Listener, Plan, Shard
from bench.execution.supervisor import Loaded, check
from bench.helpers.console import duration
from bench.helpers.errors import BenchError, nearest
from bench.helpers.parsing import JsonObject
from bench.helpers.text import count
from bench.plugins import loading
from bench.plugins.inputs import large, shown
from bench.sandbox.signals import Interrupts, interrupts_deferred
from bench.storage import provenance
from bench.storage.folder import DESCRIPTIONS, Folder, default_path, difference_line
from bench.storage.merge import Reusable, reusable, take
from bench.storage.selection import Selection
from bench.study import Study

BACKENDS = ("dask", "local")

StudyLike = Study | Mapping[str, object] | str | PathLike[str]


@dataclass
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
        spared: the optimizers of which trials were not considered for being made again, as their evaluations take long.
        doubtful: a line for each cell that gets no more trials, as a stored one differed when it was made again.
        unasked: the optimizers that took none of the points that are known (``initial``).
        journal: evaluations in the journals of interrupted trials: those ``replayed``, and those ``dropped``, as other
            points were asked for.
    """

    folder: Path
    made: int = 0
    failed: int = 0
    undeclared: dict[str, int] = field(default_factory=dict)
    different: list[str] = field(default_factory=list)
    edited: Counter[str] = field(default_factory=Counter)
    spared: list[str] = field(default_factory=list)
    doubtful: list[str] = field(default_factory=list)
    unasked: list[str] = field(default_factory=list)
    journal: Counter[str] = field(default_factory=Counter)

    @property
    def remedy(self) -> str:
        """What to do where stored trials differ, in a sentence."""
        return (
            f"nothing was added to {count(len(self.doubtful), 'cell')}, as a stored trial of each differs when it is "
            "made again: something changed that no process was seen to read, such as a library of the system or a file "
            "that C code opens; put it back, or remove the old trials and run again ('bench rm "
            f"{self.folder} --optimizer NAME'), or give another --output"
        )


@dataclass(frozen=True)
class Chosen:
    """A study on its way to its trials; each step of a run takes it and returns it with what the step found.

    Attributes:
        folder: to write.
        shard: the part to run, None for the whole study.
        task: the study as it is to be run in the folder, and the limits of its trials.
        loaded: what was found when its plug-ins were loaded.
        verify: whether one trial of each optimizer is made again at the end.
        others: the folders to be reused.
        selection: the study's cells in the folder, with what they are made from.
        notes: sentences on what was found, and on what changed since the last run.
        reused: what other folders hold of the cells, and is not taken yet.
    """

    folder: Folder
    shard: Shard | None
    task: Task
    loaded: Loaded
    verify: bool
    others: Sequence[Folder]
    selection: Selection = field(default_factory=lambda: Selection({}))
    notes: Sequence[str] = ()
    reused: Sequence[tuple[Folder, Reusable]] = ()

    @property
    def study(self) -> Study:
        """The study."""
        return self.task.study


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
    progress: bool | Listener | None = None,
) -> Outcome:
    """Run every trial of a study that its folder lacks.

    Rerunning the same call continues where the last one ended; failed trials are tried again. Results depend on the
    study alone: not on the number of jobs, on the order of trials or on the other optimizers. Every optimizer runs in
    processes of its own, so that one that hangs or crashes costs only its own trials.

    Args:
        study: a study, a dict with the keys of its file, the name of an installed one, or a TOML file's path.
        output: the folder to write, ``results/runs/<study name>`` by default.
        n_jobs: trials made at a time; -1 takes every core. Not used with dask, whose workers are the cluster's.
        backend: where trials are made, "local" (this machine) or "dask" (a cluster).
        scheduler: the address of dask's scheduler, such as "tcp://10.0.0.1:8786".
        timeout: wall seconds that a trial may take before it is stopped.
        memory: gigabytes that a trial's process may use; by default an equal share of 90% of the machine's memory.
        untrusted: keep problem, budget and trace of every trial in another process than its optimizer, run all
            plug-ins in a sandbox of bubblewrap (Linux), and limit a trial to 10 minutes and 4 GB where no other limits
            are given.
        verify: make one trial of each optimizer again at the end, in a fresh process, and note in the folder those that
            differ (:mod:`bench.execution.again`).
        reuse: folders whose trials of equal cells are taken instead of being made again.
        shard: "3/20" for the third of twenty parts; each part is run into a folder of its own.
        progress: whether to print the plan, the trials done and the failures; by default in a notebook only. A listener
            in its place gets the plan, before the first trial, and every finished trial with its row.

    Raises:
        BenchError: for a study that cannot be run or a folder that cannot take it.
        WorkerDiedError: when workers are killed several times in a row, or a cluster is lost.
        KeyboardInterrupt: on Ctrl-C, once what has finished is committed.
    """
    from bench.execution.progress import listening  # not at the top: it imports rich

    require_jobs("the number of jobs", n_jobs)
    heard = listening(progress)
    with interrupts_deferred() as interrupts, ExitStack() as held:
        with interrupts.allowed():  # loading plug-ins or reaching a cluster may take long
            pool = held.enter_context(_pool(backend, n_jobs, scheduler))
            load = partial(pool.load, shared=memory is None)
            asked = resolved(study, output, shard, untrusted, reuse, verify, timeout, memory, load)
            if asked.others:
                selected(asked)  # what cannot be reused is refused before anything is written
        folder, under_way = asked.folder, held.enter_context(asked.folder.lock())
        chosen = taken(selected(asked))
        plan = planned(chosen, at_a_time(chosen.study, pool.jobs, backend))
        limit = chosen.task.timeout
        about = provenance.run(plan.study, pool.jobs, backend, timeout=limit, shard=shard, untrusted=untrusted)
        listener = held.enter_context(heard)
        listener.plan(plan)
        make = partial(pool.answers, under_way.begin)
        with interrupts.allowed():
            doubts = doubtful(plan, folder, make)
        plan.doubtful.update(trial.key[:2] for trial in doubts)
        outcome = Outcome(folder.path, doubtful=[difference_line(trial, what) for trial, what in doubts.items()])
        repetition = Repetition(plan.study)
        _commit(outcome, plan, folder, make(plan.missing), about, interrupts, repetition, listener)
        if not (counted := folder.store.check_count()).sound:
            raise BenchError(f"the store {folder.store.path} was changed while the run wrote to it: {counted.sentence}")
        folder.note(DESCRIPTIONS, {label: asdict(each) for label, each in chosen.loaded.descriptions.items()})
        if verify:
            with interrupts.allowed():
                outcome.different = repetition.make(folder, make)
            outcome.spared = sorted(repetition.expensive)
        outcome.failed = sum(cell.failed for cell in folder.store.cells())
        outcome.undeclared = folder.store.undeclared()
        return outcome


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
    return planned(selected(resolved(study, output, shard, untrusted, reuse, verify)))


def resolved(
    study: StudyLike,
    output: str | PathLike[str] | None = None,
    shard: str | None = None,
    untrusted: bool = False,
    reuse: Sequence[str | PathLike[str]] = (),
    verify: bool = False,
    timeout: float | None = None,
    memory: float | None = None,
    load: Callable[[Task], Loaded] = check,
) -> Chosen:
    """Return a study with its folder, once its plug-ins are loaded; other arguments than ``load`` are those of `run`.

    Raises:
        BenchError: for a study that cannot be run, or not without a sandbox, and folders that cannot be reused.
    """
    for name, value, unit in (("timeout", timeout, "seconds"), ("memory", memory, "gigabytes")):
        if value is not None:
            require_positive(f"the {name} of a trial", value, unit=unit)
    part = None if shard is None else Shard.parse(shard)
    study = study if isinstance(study, Study) else Study.load(study)
    study.require_sound()
    folder, others = Folder(default_path(study) if output is None else output), [*map(Folder, reuse)]
    if any(other.path.resolve() == folder.path.resolve() for other in others):
        raise BenchError(f"{folder.path} is the folder to write; leave it out of what is reused")
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
    limits = {"timeout": timeout, "memory": None if memory is None else int(memory * 1e9)}
    task = Task.of(study, untrusted=untrusted, output=str(folder.path.absolute()), known=known, **limits)
    return Chosen(folder, part, task, load(task), verify, others)


def selected(chosen: Chosen) -> Chosen:
    """Select the study's cells in the folder, and in those to be reused; write nothing.

    Raises:
        BenchError: where the folder is damaged, or another one holds none of the cells.
    """
    folder, found = chosen.folder, chosen.loaded
    folder.require_sound()
    study, selection = folder.select(chosen.study, found.dimensions, found.present)
    reused = [(other, reusable(other, selection.cells, found.present)) for other in chosen.others]
    notes = [*(each.sentence for _, each in reused), *selection.notes]
    task = replace(chosen.task, study=study)
    return replace(chosen, task=task, selection=selection, notes=notes, reused=reused)


def taken(chosen: Chosen) -> Chosen:
    """Make the study the one of its folder, which must be locked, and take the trials of other folders."""
    folder = chosen.folder
    folder.claim(chosen.study, chosen.selection)
    folder.note_selected(chosen.study)
    for other, found in chosen.reused:
        with folder.store.writer() as writer:
            take(other, writer, found.cells, where=other.path.name)
    return replace(chosen, reused=())


def planned(chosen: Chosen, beside: str = "") -> Plan:
    """Return the plan of a study in its folder; ``beside`` is a further note."""
    study, folder, selection = chosen.study, chosen.folder, chosen.selection
    rules, notes = study.rules, [note for note in (*chosen.notes, beside) if note]
    if changed := folder.differences(provenance.machine()):
        notes.append(
            f"the trials in {folder.path} were made by another environment ({'; '.join(changed)}): new trials may "
            "differ in their last digits and their times; the report lists them separately"
        )
    if rules.time is not None:
        notes.append(
            f"a trial ends after {duration(rules.time)}, whatever it has evaluated by then: where that comes before "
            "the budget, it cannot be repeated bit by bit, and a faster or less busy machine gives other results"
        )
    if rules.evaluation_timeout is not None:
        notes.append(
            f"a point fails after {duration(rules.evaluation_timeout)}: a trial in which one did depends on the "
            "machine and is not made again"
        )
    shown = selection.labels_in(folder.store.held())
    finished, cells = folder.store.keys(finished_only=True, shown=shown), folder.store.cells(shown)
    labels = {cell: labels for labels, cell in selection.cells.items()}
    for other, found in chosen.reused:
        there = {number: cell for number, cell in other.store.held().all.items() if cell in found.cells}
        theirs = {number: labels[found.cells[cell]] for number, cell in there.items()}
        finished |= other.store.keys(finished_only=True, shown=theirs)
    return Plan(study, chosen.shard, finished, cells, notes, selection.seeds, verify=chosen.verify, folder=folder.path)


def _commit(
    outcome: Outcome,
    plan: Plan,
    folder: Folder,
    answers: Iterator[Answer],
    about: JsonObject,
    interrupts: Interrupts,
    repetition: Repetition,
    listener: Listener,
) -> None:
    """Commit the missing trials as they are made, and count them in the outcome."""
    numbers: dict[str, int] = {}  # of environments, by the machine's record
    with folder.store.writer() as writer:
        try:
            while True:
                with interrupts.allowed():
                    answer = next(answers, None)
                if answer is None:
                    return
                trial, row, machine = answer
                if machine not in numbers:
                    numbers[machine] = writer.record("environments", json.loads(machine) | about)
                    folder.write_environments()
                beside = row.pop("beside", {})
                outcome.journal.update(beside.get("journal", {}))
                if beside.get("unasked") and trial.optimizer not in outcome.unasked:
                    outcome.unasked.append(trial.optimizer)
                if others := writer.add(trial, row, numbers[machine], beside.get("inputs")):
                    outcome.edited.update(map(shown, others))
                else:
                    repetition.consider(trial, row, beside.get("after", 0))
                plan.finished.add(trial.key)
                outcome.made += 1
                listener.trial(trial, row)
        finally:
            answers.close()  # type: ignore[attr-defined]
            ended = provenance.now()
            for machine, number in numbers.items():
                writer.change(number, json.loads(machine) | about | {"ended": ended})
            if numbers:
                folder.write_environments()


def at_a_time(study: Study, jobs: int, backend: str = "local") -> str:
    """Return in a sentence how many evaluations are made at a time beside the cores there are; "" with one a job."""
    points = study.rules.parallel
    if points == 1:
        return ""
    cores = f" on {count(int(cpu_count()), 'core')}" if backend == "local" else ""
    return f"{count(jobs, 'job')} x {points} points in parallel: up to {jobs * points:,} evaluations at a time{cores}"


def _pool(backend: str, jobs: int, scheduler: str | None) -> AbstractContextManager[Local | Cluster]:
    """Return a context that yields the pool of a backend: ``jobs`` on this machine, or all workers of a scheduler.

    Raises:
        BenchError: for an unknown backend, a scheduler that is missing or cannot be reached, or workers that differ.
    """
    if backend not in BACKENDS:
        raise BenchError(f"unknown backend {backend!r}{nearest(backend, BACKENDS)}")
    if (backend == "dask") != (scheduler is not None):
        raise BenchError("the dask backend needs --scheduler tcp://HOST:PORT, and no other backend takes one")
    return Local(jobs) if scheduler is None else cluster(scheduler)
