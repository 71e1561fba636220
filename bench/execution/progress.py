"""Display the progress of a run: live bars on a terminal, plain lines elsewhere."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from time import monotonic
from types import TracebackType
from typing import Any

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    TaskID,
    TextColumn,
    TimeRemainingColumn,
)

from bench.execution.plan import Plan
from bench.helpers.console import OnStep, duration, print_line
from bench.helpers.text import count
from bench.trial import Trial

SHOWN = 20  # failures of an optimizer that are printed as they happen


class Display:
    """Displays the trials done, in total and per optimizer, and the time left."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._live = console.is_terminal
        self._progress = _bars(console, "{task.description}", TextColumn("left"), TimeRemainingColumn())
        self._bars: dict[str, TaskID] = {}
        self._failures: dict[str, int] = {}  # by optimizer
        self._made = self._left = 0
        self._started = self._printed = monotonic()

    def __enter__(self) -> Display:
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._progress.stop()

    def plan(self, plan: Plan) -> None:
        """Print the plan's size and notes, and start the bars at the trials that an earlier run made."""
        counts = plan.counts()
        show_plan(plan, counts, self._console)
        total, present = (sum(numbers) for numbers in zip(*counts.values(), strict=True))
        self._left = total - present
        self._started = monotonic()
        self._bars["all"] = self._progress.add_task("all", total=total, completed=present)
        for entry in plan.study.with_controls:
            counted = [count for (_, label), count in counts.items() if label == entry.label]
            total, present = (sum(numbers) for numbers in zip(*counted, strict=True)) if counted else (0, 0)
            self._bars[f"of {entry.label}"] = self._progress.add_task(entry.label, total=total, completed=present)

    def look(self, look: int, plan: Plan) -> None:
        """Print what a look decided, and take the trials that are not needed any more out of the bars."""
        now = [cell for cell, most in plan.stopped.items() if most == look]
        print_line(f"look at {look} trials: {_decided(now, plan, look)}", console=self._console)
        counts = plan.counts()
        self._left = self._made + sum(planned - done for planned, done in counts.values())
        for entry in plan.study.with_controls:
            total = sum(planned for (_, label), (planned, _) in counts.items() if label == entry.label)
            self._progress.update(self._bars[f"of {entry.label}"], total=total)
        self._progress.update(self._bars["all"], total=sum(planned for planned, _ in counts.values()))

    def trial(self, trial: Trial, row: dict[str, Any]) -> None:
        """Count one finished trial; print a failed one at once."""
        self._made += 1
        if row["status"] != "ok":
            reason = str(row["error"]).partition("\n")[0]
            count = self._failures[trial.optimizer] = self._failures.get(trial.optimizer, 0) + 1
            more = "; further failures of it are counted, not printed" if count == SHOWN else ""
            if count <= SHOWN:
                where = f"{trial.optimizer} on {trial.problem}, trial {trial.number}"
                print_line(f"{row['status']}: {where}: {reason}{more}", "red", self._console)
        self._progress.advance(self._bars["all"])
        self._progress.advance(self._bars[f"of {trial.optimizer}"])
        if not self._live and (monotonic() - self._printed > 15 or self._made == self._left):
            self._printed = monotonic()
            seconds = (self._printed - self._started) / self._made * (self._left - self._made)
            soon = self._made < min(20, self._left / 10)  # most of the time so far went into loading and compiling
            left = f", about {duration(seconds)} left" if self._made < self._left and not soon else ""
            print_line(f"{self._made} of {self._left} runs done{left}", console=self._console)


def displayed(progress: bool | None) -> AbstractContextManager[Display | None]:
    """Return a display of a run's progress, or of nothing; with None, a display in a notebook and nothing elsewhere."""
    wanted = in_notebook() if progress is None else progress
    return Display(Console()) if wanted else nullcontext()


def in_notebook() -> bool:
    """Return whether this process is the kernel of a notebook."""
    return Console().is_jupyter


def show_plan(plan: Plan, counts: Mapping[tuple[str, str], tuple[int, int]], console: Console) -> None:
    """Print the size of a plan, how much of it is done, and its notes."""
    study = plan.study
    total, present = (sum(numbers) for numbers in zip(*counts.values(), strict=True))
    controls = f" and {count(len(study.controls), 'control')}" if study.controls else ""
    size = f"{count(len(study.problems), 'problem')} x {count(len(study.optimizers), 'optimizer')}{controls} x "
    size += f"{'at most ' if study.looks else ''}{count(study.trials, 'trial')}"
    part = f"; shard {plan.shard} of them: {count(total, 'run')}" if plan.shard else f" = {count(total, 'run')}"
    done = f", {present:,} of them already done" if present else ""
    print_line(f"study {study.name}: {size}{part} of {study.budget_words}{done}", console=console)
    if plan.verify and (optimizers := {label for (_, label), (most, done) in counts.items() if most > done}):
        more = f"{count(len(optimizers), 'run')} more at the end: one of each optimizer is made again and compared"
        print_line(more, console=console)
    if study.looks:
        print_line(f"looks at {study.looks.words} trials: {_decided([], plan)}", console=console)
    for note in plan.notes:
        print_line(note, "yellow", console)


def _decided(now: Sequence[tuple[str, str]], plan: Plan, look: int = 0) -> str:
    """Return in words how many cells are decided by all looks so far, and those of them that the last ``look`` did."""
    named = ", ".join(f"{optimizer} on {problem}" for problem, optimizer in now[:SHOWN])
    more = f" and {len(now) - SHOWN} more" if len(now) > SHOWN else ""
    stopped = "" if look == plan.study.trials else " and stopped"
    cells, total = len(plan.study.problems) * len(plan.study.optimizers), len(plan.stopped)
    newly = f"decided{stopped} {named}{more}; " if now else ""
    return f"{newly}{total} of {cells} cells {'is' if total == 1 else 'are'} decided"


@contextmanager
def steps(console: Console, name: str) -> Iterator[OnStep]:
    """Display a progress bar; yield a function to call before each step: its title, steps done, steps in total."""
    title = TextColumn("{task.description}", markup=False)
    with _bars(console, "{task.fields[name]}", title, transient=True) as progress:
        task = progress.add_task("", name=name, total=None)

        def show(title: str, done: int, total: int) -> None:
            progress.update(task, description=title, completed=done, total=total)

        yield show


def _bars(console: Console, name: str, *columns: ProgressColumn, transient: bool = False) -> Progress:
    """Return bars of named tasks, displayed on a terminal only."""
    named = TextColumn(name, markup=False), BarColumn(), MofNCompleteColumn()
    return Progress(*named, *columns, console=console, disable=not console.is_terminal, transient=transient)
