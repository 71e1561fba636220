"""Sub-commands of the command line that are about backlash."""

from typing import Annotated

import typer

Force = Annotated[bool, typer.Option("--force", help="Replace the output if it is there.")]
