"""The compact letter display, by hand and as a property of the tests."""

import numpy as np
import pandas as pd
import pytest

from bench.analysis.cells import summarise
from bench.analysis.compare import table
from bench.analysis.letters import compact_letters
from bench.analysis.pairwise import pairwise_tests

pytestmark = pytest.mark.filterwarnings("error")
LOW, NEAR = [1.0, 2.0, 3.0, 4.0, 5.0], [1.05, 2.05, 3.05, 4.05, 5.05]
FAR = [11.0, 12.0, 13.0, 14.0, 15.0]


def row_of(letters, problem="p"):
    return table(letters, "letters").loc[problem].tolist()


@pytest.fixture
def letters_of(frame_of):
    def build(cells):
        frame = frame_of(cells)
        return compact_letters(summarise(frame), pairwise_tests(frame))

    return build


def test_by_hand(letters_of):
    above = [v + 0.1 for v in FAR]
    letters = letters_of({("p", "a"): LOW, ("p", "b"): NEAR, ("p", "c"): FAR, ("q", "a"): LOW})
    assert list(letters.columns) == ["problem", "optimizer", "letters"]
    assert row_of(letters) == ["a", "a", "b"]
    assert row_of(letters, "q") == ["a", "", ""]
    assert row_of(letters_of({("p", "a"): FAR, ("p", "b"): LOW, ("p", "c"): above})) == ["b", "a", "b"]


@pytest.mark.parametrize("seed", range(3))
def test_optimizers_share_a_letter_just_where_they_are_not_separable(frame_of, seed):
    rng = np.random.default_rng(seed)
    shifts = rng.permutation(6) * 0.45
    frame = frame_of({("p", name): rng.normal(shift, 1, 30) for name, shift in zip("abcdef", shifts, strict=True)})
    summary, pairs = summarise(frame), pairwise_tests(frame)
    letters = compact_letters(summary, pairs).set_index("optimizer")["letters"]
    for pair in pairs.itertuples():
        assert bool(set(letters[pair.first]) & set(letters[pair.second])) != pair.significant
    assert letters.nunique() > 1
    assert "a" in letters[summary.set_index("optimizer")["median"].idxmin()]


def test_at_the_level_itself_a_pair_is_separable(frame_of):
    frame = frame_of({("p", "a"): LOW, ("p", "b"): NEAR})
    pairs = pairwise_tests(frame).assign(p_holm=0.05)
    assert compact_letters(summarise(frame), pairs, alpha=0.05)["letters"].tolist() == ["a", "b"]
    assert compact_letters(summarise(frame), pairs, alpha=0.04)["letters"].tolist() == ["a", "a"]


def test_more_groups_than_letters(frame_of):
    frame = frame_of({("p", f"o{i}"): [float(i)] for i in range(53)})
    summary = summarise(frame)
    names = summary["optimizer"]
    pairs = pd.DataFrame(
        [("p", one, other, 0.0) for i, one in enumerate(names) for other in names[:i]],
        columns=["problem", "first", "second", "p_holm"],
    )
    assert compact_letters(summary, pairs)["letters"].tolist() == ["?"] * 53
    assert compact_letters(summary[1:], pairs)["letters"].nunique() == 52
