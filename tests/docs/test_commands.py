"""The reference pages of commands name the options as the command line does."""

import re
import sys
from pathlib import Path

import pytest
import typer

from bench.cli.app import app

pytest.importorskip("sphinx", reason="the pages are made by an extension of Sphinx; the dependency group docs has it")
DOCS = Path(__file__).resolve().parents[2] / "docs"
COMMANDS = typer.main.get_command(app).commands


@pytest.fixture
def commands(monkeypatch):
    monkeypatch.setattr(sys, "path", [str(DOCS), *sys.path])
    from extensions import commands

    return commands


@pytest.mark.parametrize("name", COMMANDS)
def test_a_page_has_each_option_of_its_command(name, commands):
    made = commands.page(f"bench {name}", COMMANDS[name])
    for command in (COMMANDS[name], *getattr(COMMANDS[name], "commands", {}).values()):
        for parameter in command.params:
            if parameter.param_type_name == "option":
                assert all(option in made for option in (*parameter.opts, *parameter.secondary_opts))


def test_a_page_says_what_a_value_is_and_its_default(commands):
    made = commands.page("bench run", COMMANDS["run"])
    assert re.search(r"\| `--jobs \S+` \| Worker processes; -1 takes every core\. \\\[default: -1\\\] \|", made)
    assert made.startswith("# bench run\n\nRun a study, continue one that was interrupted")
