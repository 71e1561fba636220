"""Arguments, options and usage errors that several commands share."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from bench.contract.numbers import require_jobs, span
from bench.helpers.console import print_error
from bench.helpers.text import listed
from bench.study import Study

if TYPE_CHECKING:
    from bench.execution.runner import Outcome

STUDY, PROTECTION = "The study", "Protection"
"""The headings under which the help of a command with many options has them."""

StudyFolder = Annotated[Path, typer.Argument(metavar="FOLDER", help="The folder that 'bench run' wrote.")]


@contextmanager
def interruptible() -> Iterator[None]:
    """End the command with a sentence and exit code 130 where Ctrl-C or SIGTERM interrupts it."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that its processes end
    try:
        yield
    except KeyboardInterrupt:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)  # once is enough
        print_error("interrupted; finished trials and slow evaluations are kept: the same command goes on")
        sys.exit(130)


def run_shown(study: Study, output: Path | None, console: Console, **settings: Any) -> Outcome:
    """Run a study with settings of :func:`bench.execution.runner.run`, and display its progress.

    The command ends where it is interrupted, and where a worker dies.
    """
    from bench.execution.progress import Display
    from bench.execution.runner import run
    from bench.execution.supervisor import WorkerDiedError

    try:
        with interruptible(), Display(console) as display:
            return run(study, output, progress=display, **settings)
    except WorkerDiedError as error:
        print_error(str(error))
        sys.exit(1)


def too_early(returned: Mapping[str, int]) -> str:
    """Return a line on the trials that ended before the budget without a declared reason, by optimizer."""
    who = listed([f"{label} ({number:,})" for label, number in returned.items()])
    return f"trials that ended before the budget without a declared reason: {who}"


def checked_jobs(value: int | None) -> int | None:
    """Return the value of an option that is a number of jobs; raises BenchError for a number that cannot be."""
    if value is not None:
        require_jobs("--jobs", value)
    return value


Jobs = Annotated[int, typer.Option(callback=checked_jobs, help="Worker processes; -1 takes every core.")]
Untrusted = Annotated[
    bool,
    typer.Option(
        "--untrusted",
        rich_help_panel=PROTECTION,
        help="For code that you do not trust: a sandbox of bubblewrap (Linux), problem and budget in another process, "
        "limits of time and memory.",
    ),
]
Subject = Annotated[
    str | None,
    typer.Option(
        rich_help_panel=STUDY,
        metavar="OPTIMIZER",
        help="The optimizer that the report is about: it alone is tested against each of the others.",
    ),
]
Parameters = Annotated[
    list[str] | None, typer.Option("--set", help="Parameter of the optimizer, as in agents=300; repeatable.")
]


def table(heads: Sequence[str], rows: Iterable[Sequence[object]], *, right: bool = False, title: str = "") -> Table:
    """Return a table without borders for a terminal, whose cells are printed as they are.

    Args:
        heads: of the columns; no head is printed where all are "".
        rows: the cells of each; a ``Text`` keeps its style.
        right: whether the columns but the first are aligned at the right, as numbers are.
        title: printed above the table.
    """
    made = Table(title=title or None, title_justify="left", box=None, pad_edge=False, show_header=any(heads))
    for place, head in enumerate(heads):
        made.add_column(Text(head), justify="right" if right and place else "left", overflow="fold")
    for row in rows:
        made.add_row(*(cell if isinstance(cell, Text) else Text(str(cell)) for cell in row))
    return made


def usage(error: Any) -> str:
    """Return the sentence of a usage error of typer, "" where typer printed the help in place of one."""
    report = getattr(error.__cause__, "errors", None)  # pydantic's, with which newer versions of typer read numbers
    kind, value = (report()[0]["type"], repr(report()[0]["input"])) if report else _of_click(error)
    if not kind.startswith(("int", "float", "less_than", "greater_than")):
        return str(error.format_message()).rstrip()
    limits = getattr(error.param, "type", error.param)
    number = "a whole number" if kind.startswith("int") else "a number"
    words = span(getattr(limits, "min", None), getattr(limits, "max", None))
    return f"{error.param.opts[-1]} must be {number}{words}, not {value}"


def _of_click(error: object) -> tuple[str, str]:
    """Return the type of number that click refused, "" for another error, and the value."""
    value, words, _ = getattr(error, "message", "").rpartition(" is not ")
    kind = getattr(getattr(getattr(error, "param", None), "type", None), "name", "") if words else ""
    return kind, value if value.startswith("'") else repr(value)
