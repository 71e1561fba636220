"""The ``bench`` command.

Exit codes: 1 after trials that failed or returned too early, 2 with one sentence for bad input, 130 for Ctrl-C.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import Annotated, Any

import typer

from bench.cli import (
    check,
    export,
    gate,
    import_,
    merge,
    new,
    pack,
    plan,
    report,
    reproduce,
    rm,
    run,
    solve,
    status,
    unpack,
    verify,
)
from bench.cli import list as listing
from bench.cli.console import usage
from bench.cli.versions import versions
from bench.helpers.console import print_error
from bench.helpers.errors import BenchError
from bench.plugins import registry


def _print_version(asked: bool) -> None:
    if asked:
        for name, version in versions().items():
            print(f"{name:16} {version}")
        raise typer.Exit


app = typer.Typer(
    help="Compare metaheuristics: run studies, test the results statistically and write reports.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)
PANELS: dict[str, dict[str, Callable[..., None]]] = {
    "Run": {
        "list": listing.command,
        "new": new.command,
        "run": run.command,
        "solve": solve.command,
        "merge": merge.command,
        "rm": rm.command,
    },
    "Read": {
        "status": status.command,
        "report": report.command,
        "plan": plan.command,
    },
    "Check": {
        "check": check.command,
        "reproduce": reproduce.command,
        "gate": gate.command,
        "verify": verify.command,
    },
    "Share": {
        "export": export.command,
        "import": import_.command,
        "pack": pack.command,
        "unpack": unpack.command,
    },
}
"""The commands by the panel of the help that shows them."""

for _panel, _commands in PANELS.items():
    for _name, _command in _commands.items():
        app.command(_name, rich_help_panel=_panel)(_command)

BUILT_IN = {name for commands in PANELS.values() for name in commands}
"""The commands of the harness, whose names no plug-in can take."""


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version",
            is_eager=True,
            callback=_print_version,
            help="Print the versions that a bug report needs, and end.",
        ),
    ] = False,
) -> None:
    pass


def main() -> None:
    """Run the command line; print bad input as one sentence on standard error."""
    try:
        add_plugins()
        sys.exit(_called())
    except BenchError as error:
        print_error(str(error))
        sys.exit(2)
    except (KeyboardInterrupt, typer.Abort):
        print_error("interrupted")
        sys.exit(130)
    except Exception as error:
        if not hasattr(error, "format_message"):  # a usage error of click, or of typer's own copy of it
            raise
        if sentence := usage(error):
            print_error(sentence)
        sys.exit(2)
    finally:
        for package, reason in registry.unreadable.items():
            print_error(f"plug-ins of {package} are left out, as its entry_points.txt cannot be read: {reason}")


def _called() -> Any:
    """Call the command; return its exit code.

    Raises:
        BenchError: where code of a plug-in ended it as if it had succeeded, so that nobody takes that for a success.
    """
    try:
        return app(prog_name="bench", standalone_mode=False)
    except SystemExit as ended:
        completion = {"--show-completion", "--install-completion"} & {*sys.argv}
        if ended.code or completion or "_BENCH_COMPLETE" in os.environ:
            raise
        raise BenchError("a plug-in called sys.exit, so the command ended before it was done") from ended


def add_plugins() -> None:
    """Add the sub-commands of plug-ins; raises BenchError for foreign modules of the distribution's generic names.

    One that cannot be added is named on standard error, and everything else works.
    """
    try:
        names = list(registry.entries("commands"))
    except BenchError:
        if sys.argv[1:2] == ["--version"]:  # it helps to find out why
            return
        raise
    for name in names:
        if name in BUILT_IN:
            package = registry.package("commands", name)
            print_error(f"the command {name!r} of {package} is left out: it has the name of a command of bench")
        else:
            _add_command(name)


def _add_command(name: str) -> None:
    """Add a plug-in's sub-command; one that fails to load raises its error when it is called, and breaks no other.

    The help has it in the panel that its attribute ``rich_help_panel`` names, or in that of its package.
    """
    try:
        command = registry.load("commands", name)
        if not callable(command):
            raise BenchError(f"the plug-in {name!r} of bench.commands is no function but a {type(command).__name__}")
        if not isinstance(command, typer.Typer):
            (alone := typer.Typer()).command(name)(command)
            typer.main.get_command(alone)  # raises where typer cannot read its annotations
    except Exception as error:
        cause = str(error) if isinstance(error, BenchError) else f"{type(error).__name__}: {error}"
        message = f"the command {name!r} cannot be called: {cause}"

        def command() -> None:
            raise BenchError(message)

        command.__doc__ = "(failed to load)"
    panel = getattr(command, "rich_help_panel", None) or registry.package("commands", name)
    if isinstance(command, typer.Typer):
        app.add_typer(command, name=name, rich_help_panel=panel)
    else:
        app.command(name, rich_help_panel=panel)(command)
