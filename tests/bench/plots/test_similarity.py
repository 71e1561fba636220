"""The map of similar optimizers."""

import numpy as np

from bench.analysis.similarity import similarity
from bench.plots import style
from bench.plots.similarity import similarity_map


def test_near_optimizers_share_a_label_and_the_tree_names_all(tmp_path):
    rng = np.random.default_rng(1)
    made = {name: [rng.standard_normal((20, 6)) + shift] for name, shift in (("a", 0), ("b", 0), ("c", 9), ("d", 99))}
    with style.context():
        figure = similarity_map(similarity(made))
        figure.savefig(tmp_path / "map.svg")
    left, right = figure.axes
    assert sorted(text.get_text() for text in left.texts) == ["1, 2", "3", "4"]
    assert sorted(tick.get_text() for tick in right.get_yticklabels()) == ["a  1", "b  2", "c  3", "d  4"]
