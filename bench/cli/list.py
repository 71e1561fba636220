"""bench list: print the installed plug-ins with their lineage and parameters."""

from __future__ import annotations

import json
from typing import Annotated

import typer


def list_plugins(
    kind: Annotated[
        str, typer.Argument(help="optimizers, problems, studies, commands, all, or a family's name, such as mealpy.")
    ] = "all",
    as_json: Annotated[
        bool,
        typer.Option(
            "--json", help="Print JSON records of that kind; of all: the optimizers, families' members included."
        ),
    ] = False,
) -> None:
    """List the installed plug-ins: optimizers with lineage and parameters, problems, studies, commands."""
    from rich.console import Console

    from bench.cli.listing import records, show

    if as_json:
        print(json.dumps(records(kind), indent=1, default=str))
    else:
        show(kind, Console())
