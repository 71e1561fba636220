"""Texts as Markdown."""

from bench.helpers.markdown import code, plain, table


def test_a_bar_in_a_cell_ends_no_cell():
    assert table(["name", "value"], [["a|b", "1"]]) == "| name | value |\n| - | - |\n| a\\|b | 1 |"


def test_a_name_with_a_backtick_is_in_code_font():
    assert code("gwo") == "`gwo`"
    assert code("a`b") == "``a`b``"


def test_a_plain_text_has_no_markup_and_one_line():
    assert plain("*one*\n [two](x)  #3") == "\\*one\\* \\[two\\](x) \\#3"
