"""Display the progress of a run: live bars on a terminal, plain lines elsewhere."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from time import monotonic

from rich.console import Console
from rich.progress import ProgressColumn, Task, TaskID, TextColumn, TimeRemainingColumn
from rich.text import Text

from bench.contract.families import function_of
from bench.execution.journal import best, under_way
from bench.execution.plan import Listener, Plan
from bench.helpers.console import bars, duration, print_line
from bench.helpers.errors import BenchError
from bench.helpers.text import count
from bench.trial.columns import Row
from bench.trial.trial import Trial

SHOWN = 20  # failures of an optimizer that are printed as they happen
PAUSE = 15.0  # seconds between lines where there is no terminal


class Within(ProgressColumn):
    """Displays how many evaluations the trials under way have made, and their best value, where they are slow."""

    max_refresh = 2.0  # seconds
    folder: Path | None = None

    def render(self, task: Task) -> Text:
        """Return a text for the first bar, that of all trials."""
        found = [records for _, records in under_way(self.folder)] if self.folder and task.id == 0 else []
        trials = ", ".join(f"best {best(records):.6g} of {count(len(records), 'evaluation')}" for records in found)
        return Text(f"under way: {trials}" if trials else "")


class Display(Listener):
    """Displays the trials done, in total and per optimizer, and the time left."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._within = Within()
        self._progress = bars(console, "{task.description}", TextColumn("left"), TimeRemainingColumn(), self._within)
        self._bars: dict[str, TaskID] = {}  # by optimizer; "" for all, which is the first
        self._failures: Counter[str] = Counter()  # by optimizer
        self._present = 0  # trials that earlier runs made
        self._printed = monotonic()

    def __enter__(self) -> Display:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def plan(self, plan: Plan) -> None:
        """Print the plan's size and notes, and start the bars at the trials that an earlier run made."""
        show_plan(plan, plan.counts(), self._console)
        self._within.folder = plan.folder
        for label in ("", *(entry.label for entry in plan.study.optimizers)):
            self._bars[label] = self._progress.add_task(label or "all", total=0)
        self._present = self._count(plan)

    def trial(self, trial: Trial, row: Row) -> None:
        """Count one finished trial; print a failed one at once."""
        if row["status"] != "ok":
            reason = str(row["error"]).partition("\n")[0]
            self._failures[trial.optimizer] += 1
            failures = self._failures[trial.optimizer]
            more = "; further failures of it are counted, not printed" if failures == SHOWN else ""
            if failures <= SHOWN:
                where = f"{trial.optimizer} on {trial.problem}, trial {trial.number}"
                print_line(f"{row['status']}: {where}: {reason}{more}", "red", self._console)
        for label in ("", trial.optimizer):
            self._progress.advance(self._bars[label])
        task = self._progress.tasks[0]
        if not self._console.is_terminal and (monotonic() - self._printed > PAUSE or task.finished):
            self._printed = monotonic()
            made, missing = (int(number or 0) - self._present for number in (task.completed, task.total))
            # Before each optimizer had a run, most of the time went into starting.
            paced = made >= len(self._bars) and task.time_remaining
            left = f", about {duration(paced)} left" if paced else ""
            print_line(f"{made} of {missing} runs done{left}", console=self._console)

    def _count(self, plan: Plan) -> int:
        """Set the bars to the trials of a plan and those of them that are done; return the number of the latter."""
        planned, done = Counter[str](), Counter[str]()
        for (_, optimizer), numbers in plan.counts().items():
            for label in ("", optimizer):
                planned[label] += numbers[0]
                done[label] += numbers[1]
        for label, bar in self._bars.items():
            self._progress.update(bar, total=planned[label], completed=done[label])
        return done[""]


def listening(progress: bool | Listener | None) -> AbstractContextManager[Listener]:
    """Return a listener that is given; a display for True, and for None in a notebook; else one that does nothing."""
    if isinstance(progress, Listener):
        return nullcontext(progress)
    if not isinstance(progress, bool | None):
        raise BenchError(f"progress must be true, false or a bench.Listener, not {progress!r:.100}")
    console = Console()
    wanted = console.is_jupyter if progress is None else progress
    return Display(console) if wanted else nullcontext(Listener())


def show_plan(plan: Plan, counts: Mapping[tuple[str, str], tuple[int, int]], console: Console) -> None:
    """Print the size of a plan, how much of it is done, and its notes."""
    study = plan.study
    total, present = (sum(numbers[place] for numbers in counts.values()) for place in range(2))
    functions = {function_of(entry.label) for entry in study.problems}
    pooled = f" ({len(functions):,} with instances pooled)" if len(functions) < len(study.problems) else ""
    size = f"{count(len(study.problems), 'problem')}{pooled} x {count(len(study.optimizers), 'optimizer')} x "
    size += count(study.trials, "trial")
    part = f"; shard {plan.shard} of them: {count(total, 'run')}" if plan.shard else f" = {count(total, 'run')}"
    done = f", {present:,} of them already done" if present else ""
    print_line(f"study {study.name}: {size}{part} of {study.budget_words}{done}", console=console)
    if plan.verify and (optimizers := {label for (_, label), (most, done) in counts.items() if most > done}):
        more = f"{count(len(optimizers), 'run')} more at the end: one of each optimizer is made again and compared"
        print_line(f"{more}, unless evaluations are slow", console=console)
    if total > present:
        checks = f"{count(total - present, 'evaluation')} more: each run's best point is evaluated again"
        print_line(checks, console=console)
    for note in plan.notes:
        print_line(note, "yellow", console)
