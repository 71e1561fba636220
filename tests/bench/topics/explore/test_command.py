import shlex

import pytest

from bench.helpers.console import pairs
from bench.study import Entry, Study
from bench.topics.explore.command import optimizer_words, problem_words


@pytest.mark.parametrize(
    "options",
    [{}, {"agents": 300, "start": "midpoint", "fast": True, "rate": 1e-3}, {"a": "true", "b": "it's 2", "c": "3"}],
)
def test_a_command_line_reads_the_options_back(options):
    name, *words = shlex.split(optimizer_words(Entry("gwo", "wolves", options)))
    assert name == "gwo"
    assert words[::2] == ["--set"] * len(options)
    assert pairs(words[1::2]) == options


def test_the_handling_of_constraints_is_named_where_it_is_not_the_usual():
    entry = Entry("signature-12", "s", {"unit": "rpm"})
    study = Study("s", (entry,), (), constraints="death")
    assert problem_words(entry, study) == "signature-12 --problem-option unit=rpm --constraints death"
    assert problem_words(entry, study.override(constraints="lexicographic")).endswith("unit=rpm")


def test_what_no_command_can_make_has_none():
    assert optimizer_words(Entry("imported:x", "x")) == ""
    assert optimizer_words(Entry("gwo", "g", {"table": {"a": 1}})) == ""
