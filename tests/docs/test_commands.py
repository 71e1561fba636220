"""The reference pages of commands name the options as the command line does."""

import sys
from pathlib import Path

import pytest
import typer

from bench.cli.app import app

pytest.importorskip("sphinx", reason="the pages are made by an extension of Sphinx; the dependency group docs has it")
DOCS = Path(__file__).resolve().parents[2] / "docs"
COMMANDS = typer.main.get_command(app).commands


@pytest.mark.parametrize("name", [name for name, command in COMMANDS.items() if not hasattr(command, "commands")])
def test_a_page_has_each_option_of_its_command(name, monkeypatch):
    monkeypatch.setattr(sys, "path", [str(DOCS), *sys.path])
    from extensions.commands import page

    command = COMMANDS[name]
    made = page(f"bench {name}", command.callback)
    for parameter in command.params:
        if parameter.param_type_name == "option":
            assert f"`{' / '.join([*parameter.opts, *parameter.secondary_opts])}" in made
