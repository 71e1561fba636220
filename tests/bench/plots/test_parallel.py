"""The map of the fastest optimizer by workers and cost."""

import pandas as pd

from bench import plots
from tests.bench.plots.frames import axes


def test_fields_beside_each_other_have_the_name_of_the_first_once():
    rows = [(1, 0.1, "a", 1.0), (1, 0.1, "b", 2.0), (8, 0.1, "a", 1.6), (8, 0.1, "b", 1.4), (1, 9.0, "a", 1.0)]
    rows += [(1, 9.0, "b", 2.0), (8, 9.0, "a", 2.0), (8, 9.0, "b", 1.0)]
    ax = plots.fastest_map(pd.DataFrame(rows, columns=["workers", "seconds", "optimizer", "rank"]), ax=axes())
    named = {text.get_position(): text.get_text() for text in ax.texts}  # by seconds and workers
    assert named == {(0.5, 0): "a", (0.5, 1): "b"}
    assert [tick.get_text() for tick in ax.get_yticklabels()] == ["1", "8"]
    assert [tick.get_text() for tick in ax.get_xticklabels()] == ["0.1", "9"]


def test_a_single_optimizer_is_everywhere():
    ranks = pd.DataFrame({"workers": [1, 2], "seconds": [1.0, 1.0], "optimizer": ["a", "a"], "rank": [1.0, 1.0]})
    assert [text.get_text() for text in plots.fastest_map(ranks, ax=axes()).texts] == ["a", "a"]
