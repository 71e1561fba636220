"""bench plan: which difference a study's trials can show, and how many trials a difference needs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from bench.contract.numbers import is_finite
from bench.helpers.console import print_line
from bench.helpers.errors import BenchError


def command(
    study: Annotated[
        Path, typer.Argument(metavar="FOLDER|STUDY.toml", help="A study, or the folder that 'bench run' wrote.")
    ],
    gap: Annotated[
        float, typer.Option(metavar="A12", help="The chance that a run ends lower than a rival's, to be shown.")
    ] = 0.71,
    power: Annotated[float, typer.Option(help="The chance to show it.")] = 0.8,
) -> None:
    """Print which difference a study's trials can show, and how many trials a difference needs.

    Both follow from the design alone: optimizers, problems, trials and the levels of the tests. To add trials because
    of results is optional stopping; plan a new study with another seed. Of a folder, what its results say now follows.
    """
    if not is_finite(power) or not 0.05 <= power <= 0.99:
        raise BenchError(f"the power is a chance from 0.05 to 0.99, such as 0.8, not {power:g}")
    if not is_finite(gap) or not 0.5 < gap < 1:
        raise BenchError(f"the gap is an A12 between 0.5 and 1, such as 0.71, not {gap:g}")
    from bench.cli.answer import show
    from bench.results.results import StoredResults
    from bench.storage.folder import Folder
    from bench.study import Study
    from bench.topics.trust.design import foreseen

    planned = Study.load(study) if study.suffix == ".toml" else StoredResults(study).study
    if len(planned.optimizers) < 2:
        raise BenchError(f"{study} has one optimizer only, so there is no difference to show")
    console = Console()
    for line in foreseen(planned, gap, power):
        print_line(line, console=console)
    if study.suffix != ".toml" and Folder(study).store.held().trials:
        show(study, console)
