"""Tables on a terminal: cells as they are, and nothing cut."""

from rich.console import Console
from rich.text import Text

from bench.cli.console import table


def lines(made, width=40):
    console = Console(width=width)
    with console.capture() as captured:
        console.print(made)
    return [line.rstrip() for line in captured.get().splitlines()]


def test_cells_are_printed_as_they_are_and_numbers_stand_at_the_right():
    made = table(("[b]name", "n"), [("[red]a[/red]", 7), (Text("b", "red"), 12)], right=True, title="two")
    assert lines(made) == ["two", "[b]name        n", "[red]a[/red]   7", "b             12"]
