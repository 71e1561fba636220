"""Across problems: Demšar's published example, against scipy, by hand, as properties, and coverage of the intervals."""

from itertools import combinations

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm

from bench.analysis.across import (
    across_problems,
    places,
    with_winner,
)
from bench.analysis.direction import effects, least_p
from bench.analysis.pairwise import pairwise_tests

pytestmark = pytest.mark.filterwarnings("error", "default::ResourceWarning")
INF = float("inf")


def table_of(rows, optimizers="abcdefgh"):
    rows = np.array(rows, dtype=float)
    return pd.DataFrame(rows, [f"p{i}" for i in range(len(rows))], list(optimizers[: rows.shape[1]]))


def random_table(seed, problems=10, optimizers=4):
    return table_of(np.random.default_rng(seed).gamma(2, 1, (problems, optimizers)))


def pairs_of(chances, ratio=0.05, n=10, optimizers="ab"):
    """Build pairs with these A12, one row a problem and a column a pair."""
    chances = np.array(chances, dtype=float).reshape(len(chances), -1)
    rows = [
        (f"p{problem}", *pair, n, n, chance, ratio)
        for problem, own in enumerate(chances)
        for pair, chance in zip(combinations(optimizers, 2), own, strict=True)
    ]
    return pd.DataFrame(rows, columns=["problem", "first", "second", "n_first", "n_second", "a12", "ratio"])


class TestTheseProblems:
    def test_of_one_problem_is_the_test_of_direction(self, random_frame):
        pairs = pairwise_tests(random_frame(0, problems=1))
        tests = across_problems(pairs)
        assert tests["p"].tolist() == pytest.approx(pairs["p"].tolist())
        assert tests["probability"].tolist() == pytest.approx(pairs["a12"].tolist())
        np.testing.assert_array_equal(tests["significant"], tests["p_holm"] <= 0.05)

    def test_by_hand(self):
        test = across_problems(pairs_of([0.8, 0.5, 0.6], ratio=0.12)).iloc[0]
        assert test.p == pytest.approx(2 * norm.sf((0.4 / 3) / (0.5 * np.sqrt(0.12 / 3))))
        assert (test.problems, test.lower) == (3, "a")
        assert test.probability == pytest.approx(1.9 / 3)
        assert test.joint_low == test.low < test.probability < test.high == test.joint_high

    def test_p_is_never_below_that_of_complete_separation_on_as_many_trials_as_all_problems_have(self):
        pairs = pairs_of([1.0, 1.0], ratio=0.001, n=3)
        assert across_problems(pairs).iloc[0].p == least_p(6)
        more = pairs.assign(n_first=[3, 30], n_second=[3, 30])
        assert across_problems(more).iloc[0].p == least_p(6)

    def test_single_trials_are_not_tested(self, frame_of):
        cells = {(f"p{i}", name): [float((name == "b") == (i < 9))] for i in range(10) for name in "ab"}
        row = across_problems(pairwise_tests(frame_of(cells))).iloc[0]
        assert (row.p, row.probability) == (1.0, 0.9)
        assert np.isnan([row.low, row.high]).all()

    def test_values_that_are_all_tied_differ_nowhere(self, frame_of):
        cells = {(problem, name): [0.0] * 9 for problem in "pq" for name in "ab"}
        row = across_problems(pairwise_tests(frame_of(cells))).iloc[0]
        assert (row.p, row.probability, row.lower) == (1.0, 0.5, "")
        assert row.low < 0.5 < row.high

    def test_only_problems_with_trials_of_every_optimizer_count(self):
        pairs = pairs_of(np.full((4, 3), 0.8), optimizers="abc")
        pairs.loc[(pairs["problem"] == "p1") & (pairs["second"] == "c"), ["n_second", "a12"]] = 0, np.nan
        assert across_problems(pairs)["problems"].tolist() == [3] * 3

    def test_nothing_to_compare(self, frame_of):
        for cells in ({("p", "a"): [1.0]}, {}):
            assert across_problems(pairwise_tests(frame_of(cells))).empty
        row = across_problems(pairwise_tests(frame_of({("p", "a"): [1.0, 2.0], ("q", "b"): [1.0, 2.0]}))).iloc[0]
        assert (row.problems, row.p) == (0, 1.0)
        assert row[["probability", "low", "high"]].isna().all()

    def test_the_two_directions_add_up_to_one(self, random_frame):
        frame = random_frame(0)
        forth = across_problems(pairwise_tests(frame))
        frame["optimizer"] = pd.Categorical(frame["optimizer"], list("dcba"))
        back = across_problems(pairwise_tests(frame)).set_index(["second", "first"])
        for row in forth.itertuples():
            mirrored = back.loc[(row.first, row.second)]
            ends = (row.probability, row.low, row.high, row.joint_low)
            names = ["probability", "high", "low", "joint_high"]
            assert ends == pytest.approx(tuple(1 - mirrored[names]))
            assert row.p == pytest.approx(mirrored.p)
            assert row.lower == mirrored.lower

    def test_failures_are_the_worst_and_rounding_is_a_tie(self, frame_of, one):
        cells = {("p", "a"): [1.0, 1.0], ("p", "b"): [None, None], ("q", "a"): [1.0, 2], ("q", "b"): [1 + 1e-13, 2]}
        assert one(across_problems(pairwise_tests(frame_of(cells)))).probability == 0.75


@pytest.mark.parametrize("number", [3, 18])
def test_intervals_cover_the_mean_of_these_problems(number):
    """Each of many pairs of optimizers is a study of its own: problems are drawn, and trials on them."""
    rng = np.random.default_rng(number)
    studies, n, names = 990, 10, [f"o{i:02d}" for i in range(45)]
    shift = rng.normal(0.5, 0.7, (number, studies))
    found = effects(*(rng.normal(at, 1, (number * studies, n)) for at in (0, shift.reshape(-1, 1))))
    pairs = pairs_of(found.a12.reshape(number, studies), n=n, optimizers=names).assign(ratio=found.ratio)
    table = across_problems(pairs)
    these = norm.cdf(shift / np.sqrt(2)).mean(axis=0)
    error = 3 * np.sqrt(0.93 * 0.07 / studies)
    assert ((table["low"] <= these) & (these <= table["high"])).mean() >= 0.93 - error
    assert ((table["joint_low"] <= these) & (these <= table["joint_high"])).mean() >= 0.99
    assert (table["high"] - table["low"]).mean() < (0.35 if number == 3 else 0.15)


class TestPlaces:
    def test_the_mean_over_rivals_orders_and_those_that_tie_share_a_place(self):
        # a is lower than b and than c more often than not; b is lower than c nearly always, so its mean is higher
        tests = across_problems(pairs_of([[0.51, 0.52, 0.9]], optimizers="abc"))
        found = places(tests, list("abc"))
        assert found["place"].tolist() == [2, 1, 3]
        assert found["chance"].tolist() == pytest.approx([0.515, 0.695, 0.29])
        level = places(across_problems(pairs_of([[0.5, 0.7, 0.7]], optimizers="abc")), list("abc"))
        assert level["place"].tolist() == [1.5, 1.5, 3]

    def test_a_mean_of_a_half_is_a_tie_whatever_its_rounding(self):
        tests = across_problems(pairs_of([0.7, 0.3, 0.1 + 0.2, 0.7]))
        assert places(tests, ["a", "b"])["place"].tolist() == [1.5, 1.5]
        assert tests["lower"].tolist() == [""]

    def test_a_skewed_mean_and_its_claim_agree(self):
        # lower on 24 of 29 problems, but not in the mean
        tests = across_problems(pairs_of([0.6] * 24 + [0.01] * 5, ratio=0.01))
        assert places(tests, ["a", "b"])["place"].tolist() == [2, 1]
        assert tests["lower"].item() == "b"


@pytest.mark.parametrize(
    ("p", "holm", "shown"),
    [(0.016, 0.049, [True, True, True]), (0.046, 0.05, [False, True, True]), (0.016, 0.04, [True, True, True])],
)
def test_the_pairs_of_a_winner_are_significant_without_adjustment(p, holm, shown):
    """Otherwise a page would name a winner beside 'no difference is shown between it and the second'."""
    tests = pd.DataFrame(
        {"first": ["b", "b", "a"], "second": ["a", "c", "c"], "probability": [0.29, 0.96, 1.0], "p": [p, 0.0, 0.0],
         "p_holm": [holm, 0.0, 0.0], "significant": [holm <= 0.045, True, True], "lower": ["a", "b", "a"]}
    )  # fmt: skip
    assert with_winner(tests, list("abc"), 0.045)["significant"].tolist() == shown


def test_without_a_winner_no_pair_becomes_significant():
    tests = pd.DataFrame(
        {"first": ["a", "a", "b"], "second": ["b", "c", "c"], "probability": [0.6, 0.7, 0.6], "p": [0.2, 0.01, 0.04],
         "p_holm": [0.2, 0.03, 0.08], "significant": [False, True, False], "lower": ["a", "a", "b"]}
    )  # fmt: skip
    assert with_winner(tests, list("abc"), 0.045)["significant"].tolist() == [False, True, False]
    tied = tests.assign(probability=0.5, lower="", p=0.0)
    assert with_winner(tied, list("abc"), 0.045)["significant"].tolist() == [False, True, False]
