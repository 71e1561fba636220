"""Verdicts, and how they are shown and stored."""

import json

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


def test_a_verdict_comes_back_from_json():
    for figure in (12.5, 3, None):
        verdict = Verdict("centre bias", "bias", False, "worse off the centre", "report it", figure)
        assert Verdict.from_dict(json.loads(json.dumps(verdict.as_dict()))) == verdict
