"""The region of practical equivalence that a study may name."""

import pytest

from bench import BenchError
from bench.study.rope import checked, share


@pytest.mark.parametrize(
    ("given", "held", "part"),
    [(0.5, 0.5, None), (2, 2.0, None), ("0.5", 0.5, None), ("1%", "1%", 0.01), (" 2.50 % ", "2.5%", 0.025)],
)
def test_what_is_held(given, held, part):
    assert checked(given, "the rope") == held
    assert share(held) == part
    assert checked(held, "the rope") == held


@pytest.mark.parametrize("given", [0, -1, "0%", "100%", "wide", "", True, None, [1], float("nan"), float("inf"), "1%%"])
def test_what_is_no_rope_is_refused(given):
    with pytest.raises(BenchError, match="the rope must be a positive width"):
        checked(given, "the rope")
