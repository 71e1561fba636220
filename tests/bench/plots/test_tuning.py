"""Scores over a parameter's values: numbers, choices, and defaults that the optimizer chooses itself."""

import pandas as pd
import pytest

from bench.plots import style
from bench.plots.tuning import sensitivity


def table(values):
    kinds = ["default", "best", ""][: len(values)]
    return pd.DataFrame(
        {"value": pd.Series(values, dtype=object), "score": [0.5, 0.4, 0.6][: len(values)], "kind": kinds}
    )


@pytest.mark.parametrize(
    ("values", "choices", "log", "scale", "ticks"),
    [
        ([30, 7, 200], (), True, "log", None),
        ([0.5, 0.2, 0.9], (), False, "linear", None),
        (["null", 7, 20], (), True, "log", None),
        (["null", "null"], (), True, "linear", None),
        (["box", "repair", "box"], ("repair", "box"), False, "linear", ["repair", "box"]),
        ([True, False, True], (False, True), False, "linear", ["false", "true"]),
    ],
)
def test_every_kind_of_parameter_is_drawn(values, choices, log, scale, ticks):
    figure, (ax,) = style.grid(1, columns=1, width=3, height=2, left=0.5)
    sensitivity(table(values), choices, log, ax=ax)
    figure.canvas.draw()
    assert ax.get_xscale() == scale
    if ticks:
        assert [text.get_text() for text in ax.get_xticklabels()] == ticks
        best = ax.collections[2].get_offsets()
        assert round(float(best[0, 0])) == [str(each) for each in choices].index(str(values[1]))
