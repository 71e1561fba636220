"""The standing of optimizers on a problem: by hand, in odd cases, and on problems that medians mislead about."""

import numpy as np
import pytest

from bench.analysis.cells import summarise
from bench.analysis.comparison import chances
from bench.analysis.matrix import comparison_matrix, table
from bench.analysis.pairwise import pairwise_tests

pytestmark = pytest.mark.filterwarnings("error", "default::ResourceWarning")
LOW = [float(i) for i in range(1, 11)]


@pytest.fixture
def standing_of(frame_of):
    return lambda cells: chances(frame_of(cells)).set_index("optimizer")


def test_ties_share_a_rank_and_failures_lose(standing_of):
    found = standing_of({("p", "a"): LOW, ("p", "b"): LOW, ("p", "c"): [None] * 10, ("p", "d"): [None] * 10})
    assert found["rank"].to_dict() == {"a": 1.5, "b": 1.5, "c": 3.5, "d": 3.5}


def test_a_cycle_is_a_tie(standing_of):
    dice = {("p", "a"): [2, 4, 9.0], ("p", "b"): [1, 6, 8.0], ("p", "c"): [3, 5, 7.0]}  # each ends lower, 5 to 4
    found = standing_of(dice)
    assert found["rank"].tolist() == [2.0] * 3
    found = standing_of(dice | {("p", "c"): [3, 5, 70.0]})
    assert found["rank"].idxmax() == "c"


def test_the_lowest_median_of_two_basins_may_lose_by_trials(frame_of):
    """As on signature-12 in one run: the median of ALO was the lowest, but trials of CMA-ES mostly end lower."""
    rng = np.random.default_rng(1)
    cma_es = np.append(rng.normal(5.0, 0.1, 14), rng.normal(13.0, 0.1, 16))  # the second basin holds one trial more
    frame = frame_of({("p", "cma-es"): cma_es, ("p", "alo"): rng.normal(12.5, 1.0, 30), ("p", "goa"): [20.0] * 30})
    pairs = pairwise_tests(frame)
    alo = np.sort(frame.loc[frame["optimizer"] == "alo", "fun"].to_numpy(dtype=float))
    assert alo[14] < np.median(cma_es)
    pair = pairs.iloc[0]
    assert (pair["first"], pair["second"]) == ("cma-es", "alo")
    assert pair["a12"] > 0.5
    assert table(comparison_matrix(summarise(frame), pairs), "best").loc["p"].idxmax() == "alo"
    assert table(chances(frame), "rank").loc["p"].idxmin() == "cma-es"
