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


SOUND = Verdict("centre bias", "bias", False, "worse off the centre", "report it", 50.0).as_dict()


@pytest.mark.parametrize(
    "record",
    [
        None, 5, [], "passed", {}, SOUND | {"more": 1}, {key: SOUND[key] for key in list(SOUND)[1:]},
        SOUND | {"passed": 1}, SOUND | {"kind": "praise"}, SOUND | {"kind": []}, SOUND | {"check": None},
        SOUND | {"finding": ["worse"]}, SOUND | {"figure": "50"},
    ],
)  # fmt: skip
def test_what_is_no_verdict_is_refused(record):
    with pytest.raises(ValueError, match="a verdict"):
        Verdict.from_dict(record)


def test_the_texts_of_a_verdict_are_made_printable():
    assert Verdict.from_dict(SOUND | {"finding": "\x1b[31mred"}).finding == "\N{REPLACEMENT CHARACTER}[31mred"
    assert len(Verdict.from_dict(SOUND | {"finding": "x" * 10**6}).finding) < 10**4
