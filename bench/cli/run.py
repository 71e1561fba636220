"""bench run: run a study, continue one, or extend one; then write its report."""

from __future__ import annotations

import signal
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from bench.cli.check import check_folder
from bench.cli.console import (
    MACHINES,
    PROTECTION,
    REPORT,
    STUDY,
    Jobs,
    Subject,
    Untrusted,
    run_shown,
    too_early,
)  # fmt: skip
from bench.cli.report import report_on
from bench.cli.verify import verify_folder
from bench.execution.journal import DROPPED
from bench.helpers.console import duration, print_error, print_line
from bench.helpers.errors import BenchError
from bench.helpers.text import count, listed
from bench.study import Study
from bench.trial.trial import UNASKED

if TYPE_CHECKING:
    from bench.execution.plan import Plan

_study, _machines, _protection, _afterwards = (
    partial(typer.Option, rich_help_panel=panel) for panel in (STUDY, MACHINES, PROTECTION, REPORT)
)


def command(
    study: Annotated[
        str | None,
        typer.Argument(
            help="An installed study's name (see 'bench list studies') or a TOML file.",
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder to write; default: results/runs/STUDY.")
    ] = None,
    jobs: Jobs = -1,
    trials: Annotated[
        int | None, _study(help="Trials of each optimizer on each problem, instead of the study's number.")
    ] = None,
    budget: Annotated[
        str | None, _study(help="Evaluations per trial, instead of the study's budget: a number, or such as '1e4 * d'.")
    ] = None,
    seed: Annotated[int | None, _study(help="Seed that all trials' seeds derive from, instead of the study's.")] = None,
    optimizer: Annotated[
        list[str] | None,
        _study(
            help="Add an optimizer to the study's: a name, or path/to/file.py:ClassName; repeatable.",
        ),
    ] = None,
    problem: Annotated[
        list[str] | None,
        _study(
            help="Add a problem to the study's: a name, or a pattern such as 'bbob-f08-d*'; repeatable.",
        ),
    ] = None,
    subject: Subject = None,
    backend: Annotated[
        str | None, _machines(help="Where trials are made: local (this machine) or dask, the default with --scheduler.")
    ] = None,
    scheduler: Annotated[
        str | None, _machines(metavar="ADDRESS", help="Address of dask's scheduler, as in tcp://10.0.0.1:8786.")
    ] = None,
    shard: Annotated[
        str | None, _machines(metavar="K/N", help="Run only part K of N, one per machine; see 'bench merge'.")
    ] = None,
    timeout: Annotated[
        float | None,
        _protection(metavar="SECONDS", help="Wall-clock limit of a trial; a trial that exceeds it is stopped."),
    ] = None,
    memory: Annotated[
        float | None,
        _protection(metavar="GB", help="Memory that a trial may use; default: an equal share of the machine's."),
    ] = None,
    untrusted: Untrusted = False,
    reuse: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FOLDER",
            help="Take trials of equal cells from this folder or packed archive instead of making them; repeatable.",
        ),
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Print the plan and its estimated duration only.")] = False,
    check: Annotated[
        bool, _afterwards("--check", help="Also check the optimizers (see 'bench check') before the report.")
    ] = False,
    verify: Annotated[
        int | None,
        _afterwards(
            metavar="N",
            min=0,
            help="Make N trials of each cell again (see 'bench verify') before it, 0 for none; default: one trial of "
            "each optimizer, at the end of the run.",
        ),
    ] = None,
    no_report: Annotated[bool, _afterwards("--no-report", help="Write no report when the run ends.")] = False,
) -> None:
    """Run a study, continue one that was interrupted, or extend one; then write its report.

    The same command continues where the last one ended: every finished trial is kept. An optimizer that raises, hangs
    or crashes loses only its own trials: they count as failed, and the next run tries them again.
    """
    from bench.execution.runner import plan

    if study is None:
        raise BenchError(
            "name a study: 'bench run quick' runs a small one, 'bench list studies' lists all that are installed, and "
            "'bench new study mine' writes one to begin with"
        )
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # SIGTERM ends a run like Ctrl-C, and stops the workers
    console = Console()
    chosen = Study.load(study).override(trials=trials, budget=budget, seed=seed, subject=subject)
    chosen = chosen.beside(optimizer or [], problem or [])
    if chosen.targets and chosen.targets.by_best:
        from bench.formats.coco.best2009 import best2009  # which imports pandas and scipy.stats

        best2009(entry.name for entry in chosen.problems)  # before the run, which may take long
    if dry_run:
        with _folders(reuse or []) as others:
            planned = plan(chosen, output, shard=shard, untrusted=untrusted, verify=verify is None, reuse=others)
        _show_estimate(planned, jobs, console)
        return
    with _folders(reuse or []) as others:
        outcome = run_shown(
            chosen, output, console, n_jobs=jobs, backend=backend or ("dask" if scheduler else "local"),
            scheduler=scheduler, timeout=timeout, memory=memory, shard=shard, untrusted=untrusted,
            verify=verify is None, reuse=others,
        )  # fmt: skip
    unsound = check and not check_folder(outcome.folder, console, jobs, untrusted=untrusted)
    if verify:
        try:
            unsound |= not verify_folder(outcome.folder, console, trials=verify, untrusted=untrusted)
        except BenchError as error:  # as where every trial failed; the report says more
            print_error(f"no trial could be made again: {error}")
            unsound = True
    if no_report or shard is not None:
        from bench.cli.answer import read, show, warn_if_old

        if shard is None:
            show(outcome.folder, console)
        else:  # a part of a study supports no claim yet
            warn_if_old(outcome.folder, read(outcome.folder), console)
        print_line(f"results in {outcome.folder}", console=console)
    else:
        report_on([outcome.folder], console, n_jobs=jobs)
    for line in outcome.different:
        print_line(line, "red", console)
    for line in outcome.doubtful:
        print_line(line, "red", console)
    if replayed := outcome.journal["replayed"]:
        print_line(f"{count(replayed, 'evaluation')} of interrupted trials came from the journal")
    if dropped := outcome.journal["dropped"]:
        print_error(DROPPED.format(count(dropped, "evaluation")))
    if outcome.unasked:
        print_error(UNASKED.format(listed(outcome.unasked)))
    if outcome.spared:
        print_line(
            f"evaluations are slow, so no such run of {listed(outcome.spared)} was made again at the end; "
            "'bench verify' makes some again",
            console=console,
        )
    for what, trials in outcome.edited.items():
        said = f"changed during the run: {count(trials, 'trial')} made with the new one are kept as another version"
        print_line(f"{what} {said}; the same command makes the others of it", "yellow", console)
    if outcome.failed:
        print_error(f"{count(outcome.failed, 'trial')} failed; see the report or 'bench status {outcome.folder}'")
    if outcome.different:
        print_error("some trials are not repeated bit by bit: what their optimizers keep from trial to trial, or time")
    if outcome.doubtful:
        print_error(outcome.remedy)
    if outcome.undeclared:
        remedy = 'loop until the budget ends the run, or call objective.stop("reason")'
        print_error(f"{too_early(outcome.undeclared)}; {remedy}")
    if outcome.failed or unsound or outcome.different or outcome.doubtful or outcome.undeclared:
        sys.exit(1)


@contextmanager
def _folders(paths: list[Path]) -> Iterator[list[Path]]:
    """Yield folders, those of packed archives unpacked and verified for as long."""
    with tempfile.TemporaryDirectory(prefix="bench-reuse-") as place:
        folders = []
        for path in paths:
            if path.is_file():
                from bench.formats.archive import unpack

                unpack(path, target := Path(place, path.name))
                folders.append(target)
            else:
                folders.append(path)
        yield folders


def _show_estimate(plan: Plan, jobs: int, console: Console) -> None:
    """Print a plan, each optimizer's part of it, and its duration, estimated from stored trials."""
    from joblib import cpu_count

    from bench.execution.progress import show_plan
    from bench.execution.runner import at_a_time

    counts = plan.counts()
    show_plan(plan, counts, console)
    for entry in plan.study.optimizers:
        left = [planned - done for (_, label), (planned, done) in counts.items() if label == entry.label]
        print_line(f"  {entry.label}: {sum(left)} to run", console=console)
    workers = cpu_count() if jobs == -1 else jobs
    if beside := at_a_time(plan.study, workers):
        print_line(beside, console=console)
    seconds = plan.seconds()
    if seconds is None:
        estimate = "no duration can be estimated before trials are stored: run some, as by --trials 1"
    else:
        estimate = f"about {duration(seconds / workers)} with {count(workers, 'job')}, estimated from the stored trials"
    print_line(estimate, console=console)
