"""The region of practical equivalence that a study may name."""

import numpy as np
import pytest

from bench import BenchError
from bench.study.rope import Rope


@pytest.mark.parametrize(
    ("given", "held", "words", "widths"),
    [
        (0.5, 0.5, "0.5", [0.5, 0.5, 0.5]), (2, 2.0, "2", [2, 2, 2]), ("0.5", 0.5, "0.5", [0.5, 0.5, 0.5]),
        ("1%", "1%", "1%", [0.03, 0.02, 0]), (" 2.50 % ", "2.5%", "2.5%", [0.075, 0.05, 0]),
    ],
)  # fmt: skip
def test_what_is_held(given, held, words, widths):
    rope = Rope.read(given, "the rope")
    assert (rope.plain, rope.words) == (held, words)
    assert Rope.read(held, "the rope") == rope == held
    assert rope.widths(np.array([-3.0, 4.0, np.inf]), np.array([3.0, -2.0, np.inf])) == pytest.approx(widths)


@pytest.mark.parametrize("given", [0, -1, "0%", "100%", "wide", "", True, None, [1], float("nan"), float("inf"), "1%%"])
def test_what_is_no_rope_is_refused(given):
    with pytest.raises(BenchError, match="the rope must be a positive width"):
        Rope.read(given, "the rope")
