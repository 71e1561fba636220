"""The works that a report cites, beside those that plug-ins bring."""

from bench.bibtex import parse
from bench.report.references import merge_works


def test_works_under_one_key_are_told_apart():
    ours = parse("@misc{a, year=1} @misc{b, year=2}")
    works, named = merge_works(ours, parse("@misc{a, year=1} @misc{A, year=3} @misc{c, year=4}"))
    assert [work.key for work in named] == ["a", "A-2", "c"]
    assert [work.key for work in works] == ["a", "b", "A-2", "c"]
