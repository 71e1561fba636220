"""bench run: run a study, continue one, or extend one; then write its report."""

from __future__ import annotations

import signal
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from bench.cli.check import check_folder
from bench.cli.console import PROTECTION, STUDY, Jobs, Subject, Untrusted, run_shown, too_early
from bench.cli.report import report_on
from bench.cli.verify import verify_folder
from bench.execution.journal import DROPPED
from bench.helpers.console import duration, print_error, print_line
from bench.helpers.errors import BenchError
from bench.helpers.option_groups import OptionGroup, grouped, option
from bench.helpers.text import count, listed
from bench.study import Study
from bench.trial.trial import UNASKED

if TYPE_CHECKING:
    from bench.execution.plan import Plan


class Changes(OptionGroup, panel=STUDY):
    """What this run changes of the study."""

    trials: int | None = option(help="Trials of each optimizer on each problem, instead of the study's number.")
    budget: str | None = option(
        help="Evaluations per trial, instead of the study's budget: a number, or such as '1e4 * d'."
    )
    seed: int | None = option(help="Seed that all trials' seeds derive from, instead of the study's.")
    optimizer: list[str] | None = option(
        help="Add an optimizer to the study's: a name, or path/to/file.py:ClassName; repeatable."
    )
    problem: list[str] | None = option(
        help="Add a problem to the study's: a name, or a pattern such as 'bbob-f08-d*'; repeatable."
    )
    subject: Subject = None


class Machines(OptionGroup, panel="Machines"):
    """Where the trials are made."""

    backend: str | None = option(
        help="Where trials are made: local (this machine) or dask, the default with --scheduler."
    )
    scheduler: str | None = option(metavar="ADDRESS", help="Address of dask's scheduler, as in tcp://10.0.0.1:8786.")
    shard: str | None = option(metavar="K/N", help="Run only part K of N, one per machine; see 'bench merge'.")


class Protection(OptionGroup, panel=PROTECTION):
    """What limits a trial."""

    timeout: float | None = option(
        metavar="SECONDS", help="Wall-clock limit of a trial; a trial that exceeds it is stopped."
    )
    memory: float | None = option(
        metavar="GB", help="Memory that a trial may use; default: an equal share of the machine's."
    )
    untrusted: Untrusted = False


class Afterwards(OptionGroup, panel="Afterwards"):
    """What follows the trials."""

    check: bool = option(False, "--check", help="Also check the optimizers (see 'bench check') before the report.")
    verify: int | None = option(
        metavar="N",
        min=0,
        help="Make N trials of each cell again (see 'bench verify') before it, 0 for none; default: one trial of "
        "each optimizer, at the end of the run.",
    )
    no_report: bool = option(False, "--no-report", help="Write no report when the run ends.")


@grouped
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
    *,
    changes: Changes,
    machines: Machines,
    protection: Protection,
    reuse: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FOLDER",
            help="Take trials of equal cells from this folder or packed archive instead of making them; repeatable.",
        ),
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Print the plan and its estimated duration only.")] = False,
    afterwards: Afterwards,
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
    shard, untrusted, verify = machines.shard, protection.untrusted, afterwards.verify
    chosen = Study.load(study).override(
        trials=changes.trials, budget=changes.budget, seed=changes.seed, subject=changes.subject
    )
    chosen = chosen.beside(changes.optimizer or [], changes.problem or [])
    if chosen.targets and chosen.targets.by_best:
        from bench.formats.coco.best2009 import best2009  # which imports pandas and scipy.stats

        best2009(entry.name for entry in chosen.problems)  # before the run, which may take long
    with _folders(reuse or []) as others:
        if dry_run:
            planned = plan(chosen, output, shard=shard, untrusted=untrusted, verify=verify is None, reuse=others)
            _show_estimate(planned, jobs, console)
            return
        outcome = run_shown(
            chosen, output, console, n_jobs=jobs, scheduler=machines.scheduler, shard=shard,
            backend=machines.backend or ("dask" if machines.scheduler else "local"), timeout=protection.timeout,
            memory=protection.memory, untrusted=untrusted, verify=verify is None, reuse=others,
        )  # fmt: skip
    unsound = afterwards.check and not check_folder(outcome.folder, console, jobs, untrusted=untrusted)
    if verify:
        try:
            unsound |= not verify_folder(outcome.folder, console, trials=verify, untrusted=untrusted)
        except BenchError as error:  # as where every trial failed; the report says more
            print_error(f"no trial could be made again: {error}")
            unsound = True
    if afterwards.no_report or shard is not None:
        from bench.cli.answer import read, show, warn_if_old

        if shard is None:
            show(outcome.folder, console)
        else:  # a part of a study supports no claim yet
            warn_if_old(outcome.folder, read(outcome.folder), console)
        print_line(f"results in {outcome.folder}", console=console)
    else:
        report_on([outcome.folder], console, n_jobs=jobs)
    for line in (*outcome.different, *outcome.doubtful):
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
