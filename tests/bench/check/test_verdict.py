"""Verdicts, and how they are shown and stored."""

import pytest

from bench.check import Verdict


@pytest.mark.parametrize(
    ("kind", "passed", "word"),
    [
        ("conformance", True, "passed"),
        ("bias", True, "passed"),
        ("conformance", False, "FAILED"),
        ("bias", False, "BIASED"),
    ],
)
def test_one_word_says_the_outcome(kind, passed, word):
    assert Verdict("box", kind, passed, "seen").outcome == word
