"""bench list: the plug-ins that are installed, and what is known of them."""

from __future__ import annotations

import json
from typing import Annotated

import typer


def list_plugins(
    kind: Annotated[
        str, typer.Argument(help="optimizers, problems, studies, commands, all, or a family such as mealpy.")
    ] = "all",
    as_json: Annotated[
        bool, typer.Option("--json", help="Print every optimizer, those of families too, as a JSON list.")
    ] = False,
) -> None:
    """List what is installed: optimizers with lineage and parameters, problems, studies, commands."""
    from rich.console import Console

    from bench.cli.listing import records, show

    if as_json:
        print(json.dumps(records(kind), indent=1, default=str))
    else:
        show(kind, Console())
