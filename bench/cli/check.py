"""bench check: test whether an optimizer keeps the contract, and detect its biases."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from bench.cli import completion
from bench.cli.console import Jobs, Parameters, Untrusted
from bench.errors import BenchError
from bench.helpers.console import pairs, print_error, print_line
from bench.plugins import registry

if TYPE_CHECKING:
    from bench.check.verdict import Verdict


def command(
    name: Annotated[
        str,
        typer.Argument(
            help="An optimizer (gwo, mealpy:OriginalGWO, path/to/file.py:Class), or a folder that 'bench run' wrote.",
            autocompletion=completion.checkable,
        ),
    ],
    option: Parameters = None,
    bias: Annotated[bool, typer.Option(help="Also test for biases, which takes longer.")] = True,
    untrusted: Untrusted = False,
    jobs: Jobs = -1,
    anew: Annotated[
        bool, typer.Option("--anew", help="Check a folder's optimizers again that have not changed since their check.")
    ] = False,
) -> None:
    """Check that an optimizer keeps the contract, and detect its biases towards places in the box.

    Every check prints its finding and, where it failed, how to fix it. A breach of the contract ends the command with
    exit code 1; a bias is a trait of the method and is only reported. Given a study's folder, the command checks all
    its optimizers for biases, with the study's options, and notes the findings there for the report; it keeps the
    findings on optimizers that have not changed.
    """
    from bench.check import check_optimizer

    console = Console()
    if name not in registry.entries("optimizers") and (Path(name) / "study.toml").exists():
        if option:
            raise BenchError("--set is for an optimizer given by name; a study's optimizers have their own options")
        if not check_folder(Path(name), console, jobs, anew, untrusted):
            sys.exit(1)
        return
    with console.status(f"checking {name}"):
        checkup = check_optimizer(
            name,
            bias=bias,
            untrusted=untrusted,
            n_jobs=jobs,
            on_check=lambda verdict: show_verdict(name, verdict, console),
            **pairs(option),
        )
    print_line(checkup.summary, console=console)
    if not checkup.conforms:
        sys.exit(1)


def check_folder(path: Path, console: Console, jobs: int, anew: bool = False, untrusted: bool = False) -> bool:
    """Check the optimizers of a study's folder; return whether all could be checked, biased or not."""
    from bench.check.folder import diagnose_folder
    from bench.storage.folder import Folder

    sound, kept = True, []
    with console.status("checking the optimizers for biases"):
        for diagnosis in diagnose_folder(Folder(path), jobs, anew=anew, untrusted=untrusted):
            for verdict in diagnosis.verdicts:
                show_verdict(diagnosis.label, verdict, console, remedy=False)  # 'bench check NAME' prints it
            if diagnosis.failed:
                sound = False
                print_error(f"{diagnosis.label} could not be checked: {diagnosis.failed}")
            if diagnosis.kept:
                kept.append(diagnosis.label)
    if kept:
        print_line(f"not changed since their last check: {', '.join(kept)} (--anew repeats it)", console=console)
    return sound


def show_verdict(label: str, verdict: Verdict, console: Console, remedy: bool = True) -> None:
    """Print a check's outcome and, with ``remedy``, its remedy: a breach of the contract in red, a bias in yellow."""
    style = {"passed": None, "BIASED": "yellow", "FAILED": "red"}[verdict.outcome]
    print_line(f"{verdict.outcome}: {label}, {verdict.check}: {verdict.finding}", style, console)
    if remedy and verdict.remedy:
        print_line(f"    remedy: {verdict.remedy}", style, console)
