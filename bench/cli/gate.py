"""bench gate: exit with 1 where a new version of an optimizer is worse than the stored results of the old one."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.panel import Panel
from rich.text import Text

from bench.cli.console import table
from bench.helpers.atomic import replacing
from bench.helpers.console import print_line

STYLES = {"better": "green", "not worse": "green", "worse": "red", "undecided": "yellow"}
CODES = {"better": 0, "not worse": 0, "worse": 1, "undecided": 3}


def command(
    old: Annotated[
        Path,
        typer.Argument(
            metavar="FOLDER",
            help="The folder of the old version's trials, or of both versions.",
        ),
    ],
    new: Annotated[
        Path | None,
        typer.Argument(metavar="NEW_FOLDER", help="The folder of the new version's trials."),
    ] = None,
    margin: Annotated[
        float,
        typer.Option("--not-worse-than", help="How much more than 50% of the pairs of trials the old version may win."),
    ] = 0.05,
    optimizer: Annotated[
        str | None,
        typer.Option(
            help="The optimizer to compare, where a folder has several; in one folder, 'mine@2' compares it with its "
            "version 2, and 'mine' with the version before.",
        ),
    ] = None,
    target: Annotated[
        float | None,
        typer.Option(help="Compare trials that reach this precision, such as 1e-8, by the evaluations they took."),
    ] = None,
    alpha: Annotated[float, typer.Option(help="The chance of a false alarm over all problems, at most.")] = 0.05,
    every: Annotated[
        bool,
        typer.Option("--every-problem", help="Pass only where each problem, not their average alone, is not worse."),
    ] = False,
    common: Annotated[bool, typer.Option("--common", help="Leave out problems that one folder lacks.")] = False,
    allow_undecided: Annotated[
        bool, typer.Option("--allow-undecided", help="Exit with 0 where too few trials leave it open.")
    ] = False,
    markdown: Annotated[
        Path | None, typer.Option(help="Write the verdict as Markdown into this file, for a pull request.")
    ] = None,
) -> None:
    """Compare a new version of an optimizer with an old one: 0 better or not worse, 1 worse, 3 undecided.

    A12 is the chance that a trial of the old version ends better than one of the new version. The verdict is "worse"
    where A12 is shown to exceed 50% plus the margin, on average over the problems or on one of them, "not worse" where
    it is shown to stay below on average (with --every-problem on each problem), "better" where it is then also shown to
    be below 50%, and else "undecided". The folder of the new version notes it, for later looks at more trials.
    """
    from bench.comparison.gate import HEADS, gate

    verdict = gate(old, new, margin=margin, alpha=alpha, optimizer=optimizer, target=target, common=common, every=every)
    outcome, console = verdict.found.outcome, Console()
    if markdown is not None:
        with replacing(markdown) as temporary:
            temporary.write_text(verdict.markdown(), encoding="utf-8")
    console.print(Panel(Text(verdict.sentence), title=verdict.title, style=STYLES[outcome]))
    rows = [[Text(cell, style="red" if row[-1] == "worse" else "") for cell in row] for row in verdict.rows]
    console.print(table(HEADS, rows))
    for note in verdict.notes:
        print_line(note, console=console)
    if code := 0 if allow_undecided and outcome == "undecided" else CODES[outcome]:
        sys.exit(code)
