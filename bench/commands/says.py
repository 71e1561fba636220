"""What the commands share: how they speak of trouble, and the argument that most of them take."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

Output = Annotated[Path, typer.Argument(help="The folder that 'bench run' wrote.")]


def say(message: str) -> None:
    """Print one red line on standard error."""
    Console(stderr=True).print(f"bench: {message}", style="red", markup=False, highlight=False, soft_wrap=True)
