"""Tables as Markdown."""

from bench.helpers.markdown import table


def test_a_bar_in_a_cell_ends_no_cell():
    assert table(["name", "value"], [["a|b", "1"]]) == "| name | value |\n| - | - |\n| a\\|b | 1 |"
