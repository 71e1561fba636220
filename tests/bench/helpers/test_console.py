"""Lines on the terminal."""

from bench.helpers.console import print_line


def test_a_line_is_printed_as_it_is(capsys):
    print_line("joint:100:[red].csv is 12 m long")
    assert capsys.readouterr().out == "joint:100:[red].csv is 12 m long\n"
