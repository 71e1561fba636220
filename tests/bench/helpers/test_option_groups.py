"""A command takes its options in groups, and typer sees each option."""

import typer
from typer.testing import CliRunner

from bench.helpers.option_groups import OptionGroup, grouped, option


class Wear(OptionGroup, panel="The wear"):
    months: int | None = option(help="Months to write.")
    worn: float = option(0.5, min=0.0)


def test_a_group_is_made_of_its_options_which_its_panel_shows():
    app, heard = typer.Typer(), []

    @app.command()
    @grouped
    def simulate(output: str, *, wear: Wear) -> None:
        heard.append((output, wear.months, wear.worn))

    for arguments in ("out", "out --months 3 --worn 2"):
        assert CliRunner().invoke(app, arguments.split()).exit_code == 0
    assert heard == [("out", None, 0.5), ("out", 3, 2.0)]
    assert CliRunner().invoke(app, ["out", "--worn", "-1"]).exit_code == 2
    assert "The wear" in CliRunner().invoke(app, ["--help"]).output
