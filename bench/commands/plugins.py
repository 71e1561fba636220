"""Commands for plug-ins: list, check and solve."""

from __future__ import annotations

import json
import sys
import tomllib
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from bench import listing, plugins
from bench.commands.says import say
from bench.errors import BenchError


def list_plugins(
    kind: Annotated[
        str, typer.Argument(help="optimizers, problems, studies, commands, all, or a family such as mealpy.")
    ] = "all",
    as_json: Annotated[
        bool, typer.Option("--json", help="Print every optimizer, those of families too, as a JSON list.")
    ] = False,
) -> None:
    """List what is installed: optimizers with lineage and parameters, problems, studies, commands."""
    if as_json:
        print(json.dumps(listing.records(kind), indent=1, default=str))
    else:
        listing.show(kind, Console())


def check(
    name: Annotated[
        str,
        typer.Argument(
            help="An optimizer (gwo, mealpy:OriginalGWO, path/to/file.py:Class), or a folder that 'bench run' wrote."
        ),
    ],
    option: Annotated[
        list[str] | None, typer.Option("--set", help="A parameter of the optimizer, as agents=300.")
    ] = None,
    bias: Annotated[bool, typer.Option(help="Also look for biases, which takes longer.")] = True,
    jobs: Annotated[int, typer.Option(help="Worker processes; -1 takes every core.")] = -1,
) -> None:
    """Check that an optimizer keeps the contract, and whether it favours places of the box by itself.

    Every check says what it saw and, where it failed, how to mend it. A breach of the contract ends the command with 1;
    a bias is a trait of the method, and is told. Given a study's folder, all its optimizers are checked for biases with
    their own options; what is found is noted there for the study's report.
    """
    from bench.check import check_optimizer

    console = Console()
    if name not in plugins.entries("optimizers") and (Path(name) / "study.toml").exists():
        if option:
            raise BenchError("--set is for an optimizer given by name; a study's optimizers have their own options")
        sys.exit(0 if check_folder(Path(name), console, jobs) else 1)
    checkup = check_optimizer(
        name, bias=bias, n_jobs=jobs, on_check=lambda each: listing.show_verdict(name, each, console), **pairs(option)
    )
    console.print(checkup.summary, markup=False, highlight=False, soft_wrap=True)
    if not checkup.conforms:
        sys.exit(1)


def check_folder(path: Path, console: Console, jobs: int) -> bool:
    """Check the optimizers of a study's folder; return whether all could be checked, biased or not."""
    from bench.check.folder import diagnose_folder
    from bench.folder import Folder

    found, failed = diagnose_folder(Folder(path), jobs)
    for label, verdicts in found.items():
        for each in verdicts:
            listing.show_verdict(label, each, console, mend=False)  # said once by 'bench check NAME'
    for label, reason in failed.items():
        say(f"{label} could not be checked: {reason}")
    return not failed


def solve(
    problem: Annotated[str, typer.Argument(help="A problem's name, such as signature-12 or recording:joint2.csv.")],
    optimizer: Annotated[str, typer.Argument(help="An optimizer's name, such as gwo.")],
    budget: Annotated[int, typer.Option(help="Evaluations to spend.")] = 60_000,
    seed: Annotated[int, typer.Option(help="Repeats the run; the seed of a study's row repeats that trial.")] = 0,
    option: Annotated[
        list[str] | None, typer.Option("--set", help="A parameter of the optimizer, as agents=300.")
    ] = None,
    problem_option: Annotated[list[str] | None, typer.Option(help="An option of the problem, as unit=rpm.")] = None,
) -> None:
    """Run one optimizer once on one problem and print what it found."""
    from bench.trial import solve as solve_once

    loaded = plugins.load_problem(problem, **pairs(problem_option))
    chosen = plugins.load_optimizer(optimizer, **pairs(option))
    chosen.check_budget(budget, optimizer)
    try:
        result = solve_once(loaded, chosen, budget=budget, seed=seed)
    except BenchError:
        raise
    except Exception as error:  # a plug-in may raise anything
        say(f"{optimizer} failed on {problem}: {type(error).__name__}: {error}")
        sys.exit(1)
    listing.show_result(result, loaded, Console())


def pairs(items: list[str] | None) -> dict[str, Any]:
    """Return KEY=VALUE texts as options; a value that is no TOML value is taken as a text."""
    options: dict[str, Any] = {}
    for item in items or []:
        key, equals, value = item.partition("=")
        if not equals or not key.strip():
            raise BenchError(f"{item!r} is no KEY=VALUE, as in agents=300")
        try:
            options[key.strip()] = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            options[key.strip()] = value
    return options
