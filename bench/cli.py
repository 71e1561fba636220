"""The command line. Bad input is one sentence and exit code 2; failed trials end a run with 1, Ctrl-C with 130."""

from __future__ import annotations

import sys

import typer

from bench import plugins
from bench.commands import folders, reports, runs
from bench.commands import plugins as own
from bench.commands.says import say
from bench.errors import BenchError

app = typer.Typer(
    help="Compare metaheuristics: run studies, and report what may be claimed from them.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)


def main() -> None:
    """Run the command line and turn bad input into a sentence on standard error."""
    try:
        for name in plugins.entries("commands"):  # refuses foreign modules of the distribution's generic names
            _add_command(name)
        sys.exit(app(standalone_mode=False))
    except BenchError as error:
        say(str(error))
        sys.exit(2)
    except (KeyboardInterrupt, typer.Abort):
        say("interrupted")
        sys.exit(130)
    except Exception as error:
        if not hasattr(error, "format_message"):  # a usage error of click, or of typer's own copy of it
            raise
        say(error.format_message().rstrip())
        sys.exit(2)


def _add_command(name: str) -> None:
    """Add a plug-in's sub-command; one that fails to load says so when it is called, and breaks nothing else."""
    try:
        command = plugins.load("commands", name)
    except BenchError as error:
        message = str(error)

        def command() -> None:
            raise BenchError(message)

        command.__doc__ = "(failed to load)"
    if isinstance(command, typer.Typer):
        app.add_typer(command, name=name)
    else:
        app.command(name)(command)


for _name, _command in (
    ("list", own.list_plugins), ("run", runs.run), ("status", folders.status), ("report", reports.report),
    ("export", reports.export), ("check", own.check), ("solve", own.solve), ("verify", folders.verify),
    ("merge", folders.merge), ("rm", folders.remove),
):  # fmt: skip
    app.command(_name)(_command)
