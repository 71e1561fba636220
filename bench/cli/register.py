"""bench register: a dated text of what a study will compare by which tests, before its first trial."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bench.cli import completion
from bench.helpers.console import print_line


def command(
    study: Annotated[
        str,
        typer.Argument(
            metavar="STUDY.toml", help="A study that has no trials yet, or its name.", autocompletion=completion.studies
        ),
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The folder of the study's run; default: results/runs/NAME.")
    ] = None,
) -> None:
    """Write down, with a date and a hash, what a study will compare by which tests, before its first trial.

    The text, registration.md, lies in the study's folder: problems, optimizers, trials, budget, targets, claims, their
    tests and levels, and the power of these. The report then says whether the registration was followed, or what
    differs. Give a copy of the text to others, or to a registry: nothing here proves its date.
    """
    from bench.execution.job import Task
    from bench.execution.supervisor import check
    from bench.storage.folder import default_path
    from bench.study import Study
    from bench.topics.registration.register import register

    chosen = Study.load(study)
    path = register(chosen, check(Task.of(chosen)).fingerprints, output or default_path(chosen))
    print_line(f"registered in {path}; run it with: bench run {study}" + (f" --output {output}" if output else ""))
