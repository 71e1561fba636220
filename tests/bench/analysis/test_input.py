"""What functions of bench.analysis say of arguments that they cannot take."""

import pandas as pd
import pytest

from bench import BenchError, analysis, plots

FRAME = pd.DataFrame({"problem": ["p"], "optimizer": ["a"], "trial": [0], "status": ["ok"], "fun": [1.0]})


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: analysis.summarise(FRAME.drop(columns="fun")), "summarise misses in 'frame': column 'fun'; it has"),
        (
            lambda: analysis.pairwise_tests(FRAME[["fun"]]),
            "pairwise_tests misses in 'frame': column 'optimizer'",
        ),
        (lambda: analysis.timing(FRAME), "timing misses in 'frame': .*wall_s.*; it has the columns problem, optimizer"),
        (lambda: analysis.summarise("results"), "summarise takes as 'frame' a frame, such as .* not an object of str"),
        (lambda: analysis.coverage(frame=None), "coverage takes as 'frame' a frame"),
        (lambda: analysis.holm(FRAME), "holm takes as 'p' an array of numbers, .* not an object of DataFrame"),
        (lambda: plots.box_plot("results", "p"), "box_plot takes as 'frame' a frame, such as .* not an object of str"),
        (lambda: analysis.convergence(FRAME, [], 10), "convergence takes as 'traces' traces, such as results.traces"),
    ],
)
def test_a_wrong_argument_or_a_missing_column_is_one_sentence(call, message):
    with pytest.raises(BenchError, match=message) as raised:
        call()
    assert "\n" not in str(raised.value)
