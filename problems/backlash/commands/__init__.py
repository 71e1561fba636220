"""Sub-commands of the command line that are about backlash."""

from collections.abc import Callable
from typing import Annotated, TypeVar

import typer

PANEL = "Backlash"
"""The panel of ``bench --help`` that shows these commands."""

Force = Annotated[bool, typer.Option("--force", help="Replace the output if it is there.")]
Command = TypeVar("Command", bound=Callable[..., object])


def about_backlash(command: Command) -> Command:
    """Put a command into that panel."""
    vars(command)["rich_help_panel"] = PANEL
    return command
