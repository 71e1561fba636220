"""Main effects and shares are drawn as they are, for one problem and many, with and without values."""

from itertools import product

import numpy as np
import pandas as pd

from bench.plots import style
from bench.plots.factors import main_effect, share_map


def levels(problems, values=("1", "2", "3")):
    rows = [
        (f"p{p}", "n", value, 0.3 + 0.1 * place) for p, (place, value) in product(range(problems), enumerate(values))
    ]
    return pd.DataFrame(rows, columns=["problem", "factor", "level", "chance"])


def axes():
    figure, (ax,) = style.grid(1, columns=1, width=3, height=2, left=0.5)
    return figure, ax


def test_a_line_is_a_problem_and_the_last_one_their_mean():
    figure, ax = axes()
    main_effect(levels(4), ax=ax)
    assert len(ax.lines) == 4 + 2  # the line of 0.5, and the mean
    np.testing.assert_allclose(ax.lines[-1].get_ydata(), [0.3, 0.4, 0.5])
    assert [text.get_text() for text in ax.get_xticklabels()] == ["1", "2", "3"]
    figure.canvas.draw()


def test_one_problem_and_very_many_have_the_mean_alone():
    for problems in (1, 61):
        _, ax = axes()
        main_effect(levels(problems), ax=ax)
        assert len(ax.lines) == 2


def test_the_map_has_parameters_on_its_diagonal_and_pairs_below():
    figure, ax = axes()
    share_map(pd.Series({"a": 0.5, "b": 0.2, "a × b": 0.1, "randomness of trials": 0.2}), ["a", "b"], ax=ax)
    texts = {text.get_position(): text.get_text() for text in ax.texts}
    assert texts == {(0.5, 0.5): "50%", (0.5, 1.5): "10%", (1.5, 1.5): "20%"}
    figure.canvas.draw()


def test_a_map_without_any_effect_is_drawn():
    figure, ax = axes()
    share_map(pd.Series({"a": 0.0, "b": 0.0, "a × b": 0.0}), ["a", "b"], ax=ax)
    figure.canvas.draw()
