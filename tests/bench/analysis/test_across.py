"""Across problems: Demšar's published example, against scipy, by hand, as properties, and coverage of the intervals."""

from itertools import combinations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import friedmanchisquare, norm

from bench.analysis.across import (
    across_problems,
    cliques,
    friedman,
    nemenyi,
    normalised_errors,
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


class TestDemsarsExample:
    """Demšar 2006, section 3.2.2 and Table 2; the data are his Table 6."""

    def test_friedman_and_iman_davenport(self, demsar):
        # He prints the statistics without the correction for ties, which scipy makes: four of the 14 rows have some.
        n, k = demsar.shape
        average = demsar.rank(axis=1).mean()
        assert average.round(3).tolist() == [3.143, 2.000, 2.893, 1.964]
        chi2 = 12 * n / (k * (k + 1)) * ((average**2).sum() - k * (k + 1) ** 2 / 4)
        assert round(chi2, 2) == 9.28
        assert round((n - 1) * chi2 / (n * (k - 1) - chi2), 2) == 3.69
        row = friedman(demsar).iloc[0]
        ties = sum((counts**3 - counts).sum() for counts in (row.value_counts() for _, row in demsar.iterrows()))
        assert row.statistic == pytest.approx(chi2 / (1 - ties / (n * k * (k**2 - 1))))
        assert row.iman_davenport > 3.69
        assert (row.problems, row.optimizers, row.df1, row.df2, row.note) == (14, 4, 3, 39, "")
        assert row.p_iman_davenport < row.p < 0.05

    def test_nemenyi_s_critical_differences_and_what_he_concludes(self, demsar):
        average = demsar.rank(axis=1).mean()
        strict, none = nemenyi(average, 14)
        assert round(strict, 2) == 1.25
        assert not none["significant"].any()
        lenient, some = nemenyi(average, 14, alpha=0.1)
        assert round(lenient, 2) == 1.12
        apart = some.loc[some["significant"], ["first", "second"]].to_numpy().tolist()
        assert apart == [["C4.5", "C4.5+m"], ["C4.5", "C4.5+m+cf"]]
        assert cliques(average, some) == [("C4.5+m+cf", "C4.5+m", "C4.5+cf"), ("C4.5+cf", "C4.5")]

    @pytest.mark.parametrize(
        ("alpha", "table"),
        [
            (0.05, [1.960, 2.343, 2.569, 2.728, 2.850, 2.949, 3.031, 3.102, 3.164]),
            (0.10, [1.645, 2.052, 2.291, 2.459, 2.589, 2.693, 2.780, 2.855, 2.920]),
        ],
    )
    def test_the_critical_values_are_those_of_his_table_5(self, alpha, table):
        found = [
            nemenyi(pd.Series(0.0, range(k)), problems=1, alpha=alpha)[0] / (k * (k + 1) / 6) ** 0.5
            for k in range(2, 11)
        ]
        assert found == pytest.approx(table, abs=1.1e-3)  # he rounds some to the other side


class TestFriedman:
    @pytest.mark.parametrize("seed", range(3))
    def test_against_scipy(self, seed):
        table = random_table(seed).round(0)
        row, expected = friedman(table).iloc[0], friedmanchisquare(*table.to_numpy().T)
        assert (row.statistic, row.p) == pytest.approx((expected.statistic, expected.pvalue))

    @pytest.mark.parametrize("seed", range(3))
    def test_iman_davenports_f_is_that_of_an_analysis_of_variance_of_the_ranks(self, seed):
        ranks = random_table(seed).round(0).rank(axis=1).to_numpy()
        n, k = ranks.shape
        between = n * ((ranks.mean(axis=0) - (k + 1) / 2) ** 2).sum()
        rest = ((ranks - (k + 1) / 2) ** 2).sum() - between
        expected = (between / (k - 1)) / (rest / ((k - 1) * (n - 1)))
        assert friedman(table_of(ranks)).iloc[0].iman_davenport == pytest.approx(expected)

    def test_problems_that_all_rank_alike(self):
        row = friedman(table_of([[1, 2, 3], [2, 4, 8], [0, 1, INF]])).iloc[0]
        assert (row.statistic, row.iman_davenport, row.p_iman_davenport, row.note) == (
            6.0,
            INF,
            pytest.approx(1 / 36),
            "",
        )

    def test_failures_rank_last_and_tie_among_themselves(self):
        table = table_of([[1, INF, INF], [2, INF, 5], [3, 4, INF]])
        pd.testing.assert_frame_equal(friedman(table), friedman(table.replace(INF, 1e9)))

    @pytest.mark.parametrize(
        ("rows", "note"),
        [
            ([[1, 1, 1], [2, 2, 2]], "identical"),
            ([[INF] * 3, [0] * 3], "identical"),
            ([[1, 2, 3]], "too few problems"),
            (np.empty((0, 3)), "too few problems"),
            ([[1, 2], [3, 4]], "too few optimizers"),
            (np.empty((0, 1)), "too few optimizers"),
        ],
    )
    def test_what_cannot_be_tested_says_so(self, rows, note):
        row = friedman(table_of(rows)).iloc[0]
        assert (row.note, row.p, row.p_iman_davenport) == (note, 1.0, 1.0)
        assert np.isnan([row.statistic, row.iman_davenport]).all()

    @settings(max_examples=40)
    @given(st.lists(st.lists(st.integers(-9, 9), min_size=4, max_size=4), min_size=2, max_size=9))
    def test_only_the_order_within_a_problem_counts(self, rows):
        table = table_of(rows)
        moved = table.mul(np.arange(1, len(table) + 1), axis=0) ** 3 - 5
        pd.testing.assert_frame_equal(friedman(table), friedman(moved))
        assert 0 <= friedman(table).iloc[0].p_iman_davenport <= 1


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
    def test_rivals_beaten_count_before_the_mean_and_those_that_tie_share_a_place(self):
        # a beats b barely and c barely; b beats c by far, so its mean is higher
        tests = across_problems(pairs_of([[0.51, 0.52, 0.9]], optimizers="abc"))
        found = places(tests, list("abc"))
        assert found["place"].tolist() == [1, 2, 3]
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


class TestErrors:
    def errors(self, frame_of, values, optima=None):
        frame = frame_of({("p", "a"): values[::2], ("p", "b"): values[1::2]})
        errors = normalised_errors(frame, optima)
        assert list(errors.columns) == ["problem", "optimizer", "trial", "error"]
        order = np.argsort([*range(0, len(values), 2), *range(1, len(values), 2)])
        return errors["error"].to_numpy()[order].tolist()

    def test_the_lowest_is_zero_and_the_median_is_one(self, frame_of):
        assert self.errors(frame_of, [3, 5, 9, 4, 7]) == [0, 1, 3, 0.5, 2]

    def test_the_optimum_is_zero(self, frame_of):
        assert self.errors(frame_of, [3, 5, 9, 4, 7], {"p": 1.0, "q": 0.0}) == [0.5, 1, 2, 0.75, 1.5]

    def test_a_value_below_the_optimum_is_the_best_known(self, frame_of):
        assert self.errors(frame_of, [3, 5, 9, 4, 7], {"p": 3.5}) == [0, 1, 3, 0.5, 2]

    def test_the_largest_is_one_where_most_trials_found_the_best(self, frame_of):
        assert self.errors(frame_of, [2, 2, 2, 3, 6]) == [0, 0, 0, 0.25, 1]
        errors = self.errors(frame_of, [2 + 1e-13, 2, 2 - 1e-12, 3, 6], {"p": 2.0})
        assert errors[:3] == [0, 0, 0]  # which are not 1 by rounding
        assert errors[3:] == pytest.approx([0.25, 1])

    def test_the_largest_finite_one_is_one_where_most_trials_failed(self, frame_of):
        assert self.errors(frame_of, [2, None, None, 4, 6, None, None]) == [0, INF, INF, 0.5, 1, INF, INF]

    @pytest.mark.parametrize("optima", [None, {"p": 2.0}])
    def test_all_at_the_optimum_and_all_failed(self, frame_of, optima):
        assert self.errors(frame_of, [2, 2, 2], optima) == [0, 0, 0]
        assert self.errors(frame_of, [2, None, None], optima) == [0, INF, INF]
        assert self.errors(frame_of, [None, None], optima) == [INF, INF]

    def test_each_problem_has_its_own_scale(self, frame_of):
        frame = frame_of({("p", "a"): [1, 2, 3.0], ("q", "a"): [100, 300, 500.0]})
        assert normalised_errors(frame)["error"].tolist() == [0, 1, 2] * 2
        frame["problem"] = pd.Categorical(frame["problem"], ["r", "q", "p"])
        assert normalised_errors(frame)["error"].tolist() == [0, 1, 2] * 2


class TestCliques:
    RANKS = pd.Series({"c": 3.0, "a": 1.0, "b": 2.0, "d": 4.0})

    def groups(self, *apart):
        pairs = [(one, other) for i, one in enumerate("abcd") for other in "abcd"[i + 1 :]]
        significant = [pair in apart or pair[::-1] in apart for pair in pairs]
        first, second = zip(*pairs, strict=True)
        tests = pd.DataFrame({"first": first, "second": second, "significant": significant})
        return cliques(self.RANKS, tests)

    def test_neighbours_of_which_no_pair_differs_are_joined(self):
        assert self.groups() == [("a", "b", "c", "d")]
        assert self.groups(("a", "d")) == [("a", "b", "c"), ("b", "c", "d")]
        assert self.groups(("d", "a"), ("a", "c"), ("d", "b")) == [("a", "b"), ("b", "c"), ("c", "d")]

    def test_nobody_is_joined_where_all_differ(self):
        every = [(one, other) for one in "abcd" for other in "abcd" if one < other]
        assert self.groups(*every) == []

    def test_a_group_ends_where_any_of_its_pairs_differs(self):
        assert self.groups(("b", "c")) == [("a", "b"), ("c", "d")]  # a and c, not neighbours, have no bar


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
