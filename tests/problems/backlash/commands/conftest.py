import pytest
import typer

from bench.helpers.errors import BenchError


@pytest.fixture
def command(capsys):
    """Return a function that runs a command with arguments as on a command line, and returns what it printed."""

    def run(function, *arguments):
        app = typer.Typer()
        app.command()(function)
        capsys.readouterr()
        app(list(map(str, arguments)), standalone_mode=False)
        return capsys.readouterr().out

    return run


@pytest.fixture
def refused(command):
    """Return a function that runs a command which must raise BenchError, and returns the sentence."""

    def run(function, *arguments):
        with pytest.raises(BenchError) as caught:
            command(function, *arguments)
        assert "\n" not in str(caught.value)
        return str(caught.value)

    return run
