"""bench check: test whether an optimizer or a problem keeps its contract, and detect biases of an optimizer."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from bench.cli.console import Jobs, Parameters, Untrusted
from bench.helpers.console import pairs, print_error, print_line
from bench.helpers.errors import BenchError
from bench.helpers.parallel import side_by_side
from bench.helpers.text import count
from bench.plugins import registry, selection
from bench.plugins.loading import is_problem

if TYPE_CHECKING:
    from bench.check.verdict import Checkup, Verdict


def command(
    name: Annotated[
        str,
        typer.Argument(
            help="An optimizer (gwo, mealpy:OriginalGWO), a problem, a family or a pattern of problems (signature-12, "
            "engineering, 'bbob-f*-d5-i1'), a class in a file (path/to/file.py:Class), or a folder that 'bench run' "
            "wrote.",
        ),
    ],
    option: Parameters = None,
    bias: Annotated[
        bool, typer.Option(help="Also test an optimizer for biases, which takes longer.", show_default=True)
    ] = True,
    search: Annotated[
        bool,
        typer.Option(
            "--search",
            help="Also let CMA-ES and L-SHADE try to get below a problem's optimum: 20,000 d evaluations each.",
        ),
    ] = False,
    untrusted: Untrusted = False,
    jobs: Jobs = -1,
) -> None:
    """Check that an optimizer or a problem keeps its contract, and detect an optimizer's biases in the box.

    Every check prints its finding and, where it failed, how to fix it; of several problems, the failed checks alone.
    A breach of the contract ends the command with exit code 1; a bias is a trait of the method and is only reported.
    Given a study's folder, the command checks all its optimizers for biases, with the study's options, and notes the
    findings there for the report; it keeps the findings on optimizers that have not changed.
    """
    console = Console()
    if name not in registry.entries("optimizers") and (Path(name) / "study.toml").exists():
        if option:
            raise BenchError("--set is for a plug-in given by name; a study's optimizers have their own options")
        sound = check_folder(Path(name), console, jobs, untrusted)
    elif (names := selection.members(name)) != [name] or is_problem(name):
        sound = check_problems(names, console, jobs, search=search, untrusted=untrusted, **pairs(option))
    else:
        from bench.check import check_optimizer

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
        sound = checkup.conforms
    if not sound:
        sys.exit(1)


def check_problems(names: list[str], console: Console, jobs: int, **options: Any) -> bool:
    """Check problems, several at a time, and print the verdicts in order; return whether all keep the contract."""
    from bench.check import check_problem

    def check(name: str) -> Checkup | BenchError:
        try:
            return check_problem(name, on_check=_shown(name, console, len(names)), **options)
        except BenchError as error:
            return error

    sound: list[bool] = []
    with console.status(f"checking {count(len(names), 'problem')}"):
        for name, checkup in zip(names, side_by_side(check, names, jobs), strict=True):
            if isinstance(checkup, BenchError):
                if len(names) == 1:
                    raise checkup
                sound.append(False)
                print_error(f"{name} could not be checked: {checkup}")
                continue
            sound.append(checkup.conforms)
            print_line(checkup.summary, console=console)
    if len(names) > 1:
        print_line(f"{sum(sound)} of {len(names)} problems keep the contract", console=console)
    return all(sound)


def _shown(name: str, console: Console, problems: int) -> Callable[[Verdict], None]:
    """Return a function that prints the verdicts on one of some problems; of several, only those that failed."""

    def show(verdict: Verdict) -> None:
        if problems == 1 or not verdict.passed:
            show_verdict(name, verdict, console)

    return show


def check_folder(path: Path, console: Console, jobs: int, untrusted: bool = False) -> bool:
    """Check the optimizers of a study's folder; return whether all could be checked, biased or not."""
    from bench.check.folder import diagnose_folder
    from bench.storage.folder import Folder

    sound, kept = True, []
    with console.status("checking the optimizers for biases"):
        for diagnosis in diagnose_folder(Folder(path), jobs, untrusted=untrusted):
            for verdict in diagnosis.verdicts:
                show_verdict(diagnosis.label, verdict, console, remedy=False)  # 'bench check NAME' prints it
            if diagnosis.failed:
                sound = False
                print_error(f"{diagnosis.label} could not be checked: {diagnosis.failed}")
            if diagnosis.kept:
                kept.append(diagnosis.label)
    if kept:
        print_line(f"not changed since their last check: {', '.join(kept)}", console=console)
    return sound


def show_verdict(label: str, verdict: Verdict, console: Console, remedy: bool = True) -> None:
    """Print a check's outcome and, with ``remedy``, its remedy: a breach of the contract in red, a bias in yellow."""
    style = {"passed": None, "BIASED": "yellow", "FAILED": "red"}[verdict.outcome]
    print_line(f"{verdict.outcome}: {label}, {verdict.check}: {verdict.finding}", style, console)
    if remedy and verdict.remedy:
        print_line(f"    remedy: {verdict.remedy}", style, console)
