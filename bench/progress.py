"""What a person sees while a study runs: live bars on a terminal, plain lines elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from types import TracebackType
from typing import Any

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TaskID,
    TextColumn,
    TimeRemainingColumn,
)

from bench.study import Study, Trial


class Display:
    """Trials done, in all and per optimizer, and the time left."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._live = console.is_terminal
        self._progress = Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            console=console,
            disable=not self._live,
        )
        self._bars: dict[str, TaskID] = {}
        self._failed = 0
        self._made = self._left = 0
        self._started = self._spoken = monotonic()

    def __enter__(self) -> Display:
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._progress.stop()

    def plan(self, study: Study, done: set[tuple[str, str, int]]) -> None:
        """Show the plan: how many trials there are and how many an earlier run already made."""
        keys = {trial.key for trial in study.plan()}
        present = keys & done
        self._left = len(keys) - len(present)
        self._started = monotonic()
        size = f"{len(study.problems)} problems x {len(study.optimizers)} optimizers x {study.trials} trials"
        self._console.print(
            f"study {study.name}: {size} = {len(keys)} runs of {study.budget} evaluations"
            + (f", {len(present)} of them already done" if present else ""),
            markup=False, highlight=False, soft_wrap=True,
        )  # fmt: skip
        self._bars["all"] = self._progress.add_task("all", total=len(keys), completed=len(present))
        for entry in study.optimizers:
            mine = sum(key[1] == entry.label for key in present)
            total = len(study.problems) * study.trials
            self._bars[f"of {entry.label}"] = self._progress.add_task(entry.label, total=total, completed=mine)

    def trial(self, trial: Trial, row: dict[str, Any]) -> None:
        """Count one finished trial; a failed one is said at once."""
        self._made += 1
        if row["status"] != "ok":
            self._failed += 1
            reason = str(row["error"]).splitlines()[0]
            self._console.print(
                f"failed: {trial.optimizer} on {trial.problem}, trial {trial.number}: {reason}",
                markup=False, highlight=False, soft_wrap=True, style="red",
            )  # fmt: skip
        self._progress.advance(self._bars["all"])
        self._progress.advance(self._bars[f"of {trial.optimizer}"])
        if not self._live and (monotonic() - self._spoken > 15 or self._made == self._left):
            self._spoken = monotonic()
            rest = (self._spoken - self._started) / self._made * (self._left - self._made)
            left = f", about {rest:.0f} s left" if self._made < self._left else ""
            self._console.print(f"{self._made} of {self._left} runs done{left}", highlight=False)


@contextmanager
def steps(console: Console, name: str) -> Iterator[Callable[[str, int, int], None]]:
    """Show a bar for work in known steps; yields what to call before each: its title, steps done, steps in all."""
    progress = Progress(
        TextColumn("{task.fields[name]}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.description}", markup=False),
        console=console,
        disable=not console.is_terminal,
        transient=True,
    )
    with progress:
        task = progress.add_task("", name=name, total=None)

        def show(title: str, done: int, total: int) -> None:
            progress.update(task, description=title, completed=done, total=total)

        yield show
