"""Nemenyi's test and the groups of a critical-difference diagram, against scikit-posthocs and by hand."""

from itertools import combinations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scikit_posthocs import posthoc_nemenyi_friedman

from bench.analysis.across import average_ranks, cliques, critical_difference, nemenyi
from tests.bench.analysis.tables import random_table, table_of

pytestmark = pytest.mark.filterwarnings("error")
INF = float("inf")


class TestNemenyi:
    @pytest.mark.parametrize("seed", range(3))
    def test_against_scikit_posthocs_and_the_critical_difference(self, seed):
        table = random_table(seed, problems=6)
        expected = posthoc_nemenyi_friedman(table)
        ranks = average_ranks(table)
        for pair in nemenyi(table).itertuples():
            assert pair.p == pytest.approx(expected.loc[pair.first, pair.second])
            gap = abs(ranks[pair.first] - ranks[pair.second])
            assert (pair.p <= 0.05) == (gap >= critical_difference(4, 6))

    def test_failures(self):
        table = table_of([[1, INF, INF], [2, INF, 5], [3, 4, INF]])
        pd.testing.assert_frame_equal(nemenyi(table), nemenyi(table.replace(INF, 1e9)))

    def test_nothing_to_compare(self):
        assert nemenyi(table_of([[1], [2]])).empty
        assert nemenyi(table_of(np.empty((0, 3))))["p"].tolist() == [1.0] * 3


class TestCliques:
    @pytest.mark.parametrize(
        ("ranks", "difference", "expected"),
        [
            ({"a": 1.0, "b": 2.0, "c": 3.0}, 1.5, [("a", "b"), ("b", "c")]),
            ({"a": 3.0, "b": 2.0, "c": 1.0}, 2.5, [("c", "b", "a")]),
            ({"a": 1.0, "b": 2.0, "c": 3.0}, 1.0, []),  # a difference as large as the critical one is significant
            ({"a": 1.0, "b": 1.2, "c": 2.9, "d": 3.0}, 0.5, [("a", "b"), ("c", "d")]),
            ({"a": 1.5, "b": 1.5}, 1.0, [("a", "b")]),
            ({"a": 1.0}, 1.0, []),
            ({}, 1.0, []),
        ],
    )
    def test_by_hand(self, ranks, difference, expected):
        assert cliques(pd.Series(ranks, dtype=float), difference) == expected

    @given(st.lists(st.integers(0, 20), max_size=8), st.integers(1, 10))
    def test_a_pair_shares_a_group_just_where_it_is_close(self, ranks, difference):
        series = pd.Series(ranks, index=[f"o{i}" for i in range(len(ranks))], dtype=float)
        groups = [set(group) for group in cliques(series, difference)]
        for one, other in combinations(series.index, 2):
            together = any({one, other} <= group for group in groups)
            assert together == (abs(series[one] - series[other]) < difference)
        assert not any(one < other for one in groups for other in groups)
