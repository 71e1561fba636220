"""A bar for what takes long: on a terminal alone, gone at the end, and never in the way of the items."""

from io import StringIO
from time import monotonic, sleep

import pytest
from rich.console import Console

from problems.backlash.commands.progress import progress


@pytest.mark.parametrize("terminal", [True, False])
def test_items_are_returned_whether_a_bar_is_drawn_or_not(terminal):
    console = Console(file=StringIO(), force_terminal=terminal)
    with progress("counting", 3, console) as track:
        assert list(track(range(3))) == [0, 1, 2]
    assert "counting" not in console.file.getvalue()  # it took no two seconds


def test_a_bar_appears_on_a_terminal_once_it_is_late():
    console, end = Console(file=StringIO(), force_terminal=True), monotonic() + 60
    with progress("counting", 1, console, late=0.0) as track:
        for _ in track([1]):
            while "counting" not in console.file.getvalue() and monotonic() < end:
                sleep(0.01)
    assert "counting" in console.file.getvalue()
