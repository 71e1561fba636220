"""Names as file names, unique names, and printable text."""

import re

import pytest

from bench.helpers.text import file_name, free, printable, unique
from tests.bench.names import HOSTILE


class TestFileNames:
    @pytest.mark.parametrize("name", HOSTILE)
    def test_hostile_names_stay_in_their_folder(self, name):
        assert re.fullmatch(r"[a-z0-9_][a-z0-9_-]*", file_name(name))

    def test_names_that_differ_never_share_a_file(self):
        names = [*HOSTILE, "a-b", "a/b", "a:b", "A-B"]
        assert len({file_name(name) for name in names}) == len(names)


def test_names_that_collide_are_numbered():
    assert unique(["a", "b", "a", "a-2", "a"]) == ["a", "b", "a-2", "a-2-2", "a-3"]
    assert free("a", ["b"]) == "a"
    assert free("a", ["a", "a-2"]) == "a-3"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain\nlines", "plain\nlines"),
        ("a\tb", "a b"),
        ("bell\x07", "bell\ufffd"),
        ("\u202eltr\u202c", "\ufffdltr\ufffd"),
        ("zero\u200bwidth", "zero\ufffdwidth"),
        ("x" * 20, "x" * 20),
        ("x" * 21, "x" * 20 + "…"),
    ],
)
def test_printable_text_has_no_hidden_characters_and_a_limit(text, shown):
    assert printable(text, 20) == shown
