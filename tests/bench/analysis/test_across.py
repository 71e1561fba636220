"""Across problems: Demšar's published example, against scipy, by hand, as properties, and coverage of the intervals."""

from itertools import combinations, product

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import friedmanchisquare, norm, rankdata, t, wilcoxon

from bench.analysis.across import (
    cliques,
    friedman,
    normalised_errors,
    probability_of_improvement,
    ranks_by_block,
    signed_ranks,
    stratified_tests,
    wilcoxon_tests,
)
from bench.analysis.cells import summarise
from bench.analysis.direction import effects, intervals, least_p
from bench.analysis.pairwise import holm, pairwise_tests
from bench.analysis.standings import mean_ranks, standings

pytestmark = pytest.mark.filterwarnings("error", "default::ResourceWarning")
INF = float("inf")
TESTS = ["first", "second", "problems", "blocks", "statistic", "p", "p_holm", "significant", "lower", "note"]


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

    def test_signed_ranks(self, demsar):
        # His sums are 93 and 12. Two of the 14 differences are zero: he splits their ranks, as zero_method="zsplit".
        difference = (demsar["C4.5"] - demsar["C4.5+m"]).round(4).to_numpy()
        assert wilcoxon(difference, zero_method="zsplit").statistic == 12
        found = signed_ranks(difference)
        assert (found["statistic"], found["lower"], found["note"]) == (12, 93 - 12, "")
        assert found["p"] <= 0.05


class TestRanks:
    def test_of_blocks_are_means_over_their_complete_problems(self, frame_of):
        low, far = [1.0, 2.0], [5.0, 6.0]
        cells = {(problem, name): values for problem in "pqr" for name, values in (("a", low), ("b", far))}
        cells |= {("q", "a"): far, ("q", "b"): low, ("s", "a"): low}
        frame = frame_of(cells)
        standing = standings(summarise(frame), pairwise_tests(frame))
        ranks = ranks_by_block(standing, {"p": "sweep", "q": "sweep"})
        assert ranks.to_dict("index") == {"sweep": {"a": 1.5, "b": 1.5}, "r": {"a": 1.0, "b": 2.0}}
        assert ranks_by_block(standing).mean().to_dict() == mean_ranks(standing).to_dict()


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


class TestWilcoxon:
    @pytest.mark.parametrize("seed", range(3))
    def test_against_scipy(self, seed):
        chances = np.random.default_rng(seed).random((18, 6)) ** 0.7
        tests = wilcoxon_tests(pairs_of(chances, optimizers="abcd"))
        assert list(tests.columns) == TESTS
        assert list(zip(tests["first"], tests["second"], strict=True)) == list(combinations("abcd", 2))
        for test, own in zip(tests.itertuples(), chances.T, strict=True):
            expected = wilcoxon(own - 0.5, method="exact")
            assert (test.statistic, test.p) == pytest.approx((expected.statistic, expected.pvalue))
            favoured = wilcoxon(own - 0.5, alternative="greater").pvalue < 0.5
            assert test.lower == (test.first if favoured else test.second)
            assert (test.problems, test.blocks, test.note) == (18, 18, "")
        np.testing.assert_array_equal(tests["p_holm"], holm(tests["p"].to_numpy()))
        np.testing.assert_array_equal(tests["significant"], tests["p_holm"] <= 0.05)

    def test_the_unit_is_the_block(self):
        rng = np.random.default_rng(4)
        chances, blocks = rng.random(24), {f"p{i}": f"b{i // 3}" for i in range(21)}  # the last three are alone
        test = wilcoxon_tests(pairs_of(chances), blocks).iloc[0]
        means = [*chances[:21].reshape(7, 3).mean(axis=1), *chances[21:]]
        expected = wilcoxon_tests(pairs_of(means)).iloc[0]
        assert (test.problems, test.blocks) == (24, 10)
        assert (test.statistic, test.p, test.lower) == (expected.statistic, expected.p, expected.lower)

    def test_opposite_values_of_a_block_leave_no_difference(self):
        test = wilcoxon_tests(pairs_of([0.7, 0.3, 0.1 + 0.2, 0.7]), dict.fromkeys(("p0", "p1", "p2", "p3"), "b")).iloc[
            0
        ]
        assert (test.p, test.p_holm, test.significant, test.lower, test.note) == (1.0, 1.0, False, "", "identical")

    @pytest.mark.parametrize("seed", range(4))
    def test_ties_and_zeros_against_all_flips_of_the_signs(self, seed):
        difference = np.random.default_rng(seed).integers(-2, 5, 9)
        size = rankdata(np.abs(difference))
        flips = np.array(list(product((-1, 1), repeat=9)))
        sums = (flips * np.where(difference == 0, 0, size)).sum(axis=1)
        seen = (np.sign(difference) * size).sum()
        test = wilcoxon_tests(pairs_of(0.5 + difference / 10)).iloc[0]
        assert test.p == pytest.approx(np.mean(np.abs(sums) >= abs(seen)))
        assert test.statistic == (45 - abs(seen)) / 2

    @pytest.mark.parametrize(("differing", "note"), [(5, "untestable"), (6, "")])
    def test_too_few_differences_are_untestable(self, differing, note):
        test = wilcoxon_tests(pairs_of([0.6 + i / 50 for i in range(differing)] + [0.5] * 9)).iloc[0]
        assert (test.note, test.lower) == (note, "a")
        assert (test.p == 1.0) == bool(note)

    @pytest.mark.parametrize("n", [63, 65, 100])
    def test_many_problems(self, n):
        chances = np.random.default_rng(n).random(n)
        test, expected = wilcoxon_tests(pairs_of(chances)).iloc[0], wilcoxon(chances - 0.5, method="exact")
        assert (test.statistic, test.p) == pytest.approx((expected.statistic, expected.pvalue))
        alike = wilcoxon_tests(pairs_of(0.5 + np.arange(1, n + 1) / 250)).iloc[0]
        assert (alike.statistic, alike.lower, alike.p) == (0, "a", pytest.approx(2.0 ** (1 - n), rel=1e-12))

    def test_only_problems_with_trials_of_every_optimizer_count(self):
        pairs = pairs_of(np.full((4, 3), 0.8), optimizers="abc")
        pairs.loc[(pairs["problem"] == "p1") & (pairs["second"] == "c"), ["n_second", "a12"]] = 0, np.nan
        assert wilcoxon_tests(pairs)["problems"].tolist() == [3] * 3
        assert stratified_tests(pairs)["problems"].tolist() == [3] * 3

    @pytest.mark.parametrize("function", [wilcoxon_tests, stratified_tests])
    def test_nothing_to_compare(self, function, frame_of):
        assert function(pairwise_tests(frame_of({("p", "a"): [1.0]}))).empty
        tests = function(pairwise_tests(frame_of({("p", "a"): [1.0, 2.0], ("q", "b"): [1.0, 2.0]})))
        assert tests[["problems", "blocks", "p", "note"]].to_numpy().tolist() == [[0, 0, 1.0, "untestable"]]

    @settings(max_examples=20)
    @given(st.lists(st.integers(0, 20), min_size=1, max_size=9), st.sampled_from([wilcoxon_tests, stratified_tests]))
    def test_swapping_the_optimizers_swaps_only_the_favour(self, wins, function):
        chances = np.array(wins) / 20
        test, mirrored = (function(pairs_of(own)).iloc[0] for own in (chances, 1 - chances))
        assert (test.statistic, test.p) == pytest.approx((mirrored.statistic, mirrored.p))
        assert {test.lower, mirrored.lower} in ({"a", "b"}, {""})
        assert 0 < test.p <= test.p_holm <= 1


class TestStratified:
    def test_of_one_problem_is_the_test_of_direction(self, random_frame):
        pairs = pairwise_tests(random_frame(0, problems=1))
        tests = stratified_tests(pairs)
        assert list(tests.columns) == TESTS
        assert tests["p"].tolist() == pytest.approx(pairs["p"].tolist())
        np.testing.assert_array_equal(tests["p_holm"], holm(tests["p"].to_numpy()))

    def test_by_hand(self):
        test = stratified_tests(pairs_of([0.8, 0.5, 0.6], ratio=0.12), {"p0": "b", "p1": "b"}).iloc[0]
        assert test.statistic == pytest.approx((0.4 / 3) / (0.5 * np.sqrt(0.12 / 3)))
        assert test.p == pytest.approx(2 * norm.sf(test.statistic))
        assert (test.problems, test.blocks, test.lower, test.note) == (3, 2, "a", "")

    def test_p_is_never_below_that_of_complete_separation(self):
        test = stratified_tests(pairs_of([1.0, 1.0], ratio=0.001, n=3)).iloc[0]
        assert (test.p, test.lower) == (least_p(6), "a")

    def test_a_single_trial_is_untestable(self, frame_of):
        cells = {("p", "a"): [1.0, 2.0], ("p", "b"): [3.0, 4.0], ("q", "a"): [1.0], ("q", "b"): [2.0]}
        test = stratified_tests(pairwise_tests(frame_of(cells))).iloc[0]
        assert (test.p, test.note, test.significant) == (1.0, "untestable", False)


class TestImprovement:
    def test_by_hand(self, frame_of, one):
        frame = frame_of(
            {
                ("p", "a"): [1.0, 2.0], ("p", "b"): [3.0, 4.0],
                ("q", "a"): [1.0, 3.0], ("q", "b"): [2.0, 2.0],
                ("r", "a"): [1.0, 3.0],
            }
        )  # fmt: skip
        row = one(probability_of_improvement(pairwise_tests(frame)))
        assert (row["first"], row.second, row.problems, row.blocks, row.probability) == ("a", "b", 2, 2, 0.75)
        assert 0 < row.low < row.probability < row.high < 1
        assert np.isnan([row.further_low, row.further_high]).all()  # of two blocks

    def test_further_problems_are_further_blocks(self):
        chances, blocks = [0.9, 0.7, 0.6, 0.4, 0.8], {"p0": "b", "p1": "b"}
        row = probability_of_improvement(pairs_of(chances), blocks).iloc[0]
        means = np.array([0.8, 0.6, 0.4, 0.8])
        for end in (row.further_low, row.further_high):  # the mean has the t of its level under either end
            centre = means.mean()
            size = abs(centre - end) / np.sqrt(means.var(ddof=1) / 4 / (centre * (1 - centre)) * end * (1 - end))
            assert size == pytest.approx(t.ppf(0.975, 3))
        assert row.further_low < row.further_high
        assert (row.problems, row.blocks, row.probability) == (5, 4, pytest.approx(np.mean(chances)))

    def test_blocks_that_are_all_won_leave_a_doubt(self):
        row = probability_of_improvement(pairs_of([1.0] * 4)).iloc[0]
        assert (row.further_low, row.further_high) == (pytest.approx(0.025**0.25), pytest.approx(1))
        assert row.low < 1

    def test_one_problem_has_nearly_the_interval_of_its_a12(self):
        rng = np.random.default_rng(0)
        found = effects(rng.normal(size=(1, 30)), rng.normal(0.5, 1, (1, 30)))
        row = probability_of_improvement(pairs_of(found.a12, found.ratio[0], 30)).iloc[0]
        low, high = intervals(found)
        assert (row.low, row.high) == pytest.approx((low[0], high[0]), abs=1e-6)

    @pytest.mark.parametrize("seed", range(2))
    def test_the_two_directions_add_up_to_one(self, random_frame, seed):
        frame = random_frame(seed)
        forth = probability_of_improvement(pairwise_tests(frame))
        frame["optimizer"] = pd.Categorical(frame["optimizer"], list("dcba"))
        back = probability_of_improvement(pairwise_tests(frame)).set_index(["second", "first"])
        for row in forth.itertuples():
            mirrored = back.loc[(row.first, row.second)]
            ends = (row.probability, row.low, row.high, row.further_low, row.further_high)
            names = ["probability", "high", "low", "further_high", "further_low"]
            assert ends == pytest.approx(tuple(1 - mirrored[names]))
        assert list(zip(forth["first"], forth["second"], strict=True)) == list(combinations("abcd", 2))

    def test_failures_are_the_worst_and_rounding_is_a_tie(self, frame_of, one):
        cells = {("p", "a"): [1.0, 1.0], ("p", "b"): [None, None], ("q", "a"): [1.0, 2], ("q", "b"): [1 + 1e-13, 2]}
        assert one(probability_of_improvement(pairwise_tests(frame_of(cells)))).probability == 0.75

    def test_a_single_trial_leaves_no_interval_for_these_problems(self, frame_of, one):
        row = one(probability_of_improvement(pairwise_tests(frame_of({("p", "a"): [1.0, 2.0], ("p", "b"): [3.0]}))))
        assert row.probability == 1.0
        assert np.isnan([row.low, row.high]).all()

    def test_no_problem_with_every_optimizer(self, frame_of, one):
        row = one(probability_of_improvement(pairwise_tests(frame_of({("p", "a"): [1.0], ("q", "b"): [1.0]}))))
        assert row.problems == 0
        assert row[["probability", "low", "high", "further_low", "further_high"]].isna().all()

    def test_one_optimizer_and_an_empty_frame(self, frame_of):
        for cells in ({("p", "a"): [1.0]}, {}):
            assert probability_of_improvement(pairwise_tests(frame_of(cells))).empty

    @pytest.mark.parametrize("number", [3, 18])
    def test_coverage_of_these_and_of_further_problems(self, number):
        """Each of many pairs of optimizers is a study of its own: problems are drawn, and trials on them."""
        rng = np.random.default_rng(number)
        studies, n, names = 990, 10, [f"o{i:02d}" for i in range(45)]
        shift = rng.normal(0.5, 0.7, (number, studies))
        found = effects(*(rng.normal(at, 1, (number * studies, n)) for at in (0, shift.reshape(-1, 1))))
        pairs = pairs_of(found.a12.reshape(number, studies), n=n, optimizers=names).assign(ratio=found.ratio)
        table = probability_of_improvement(pairs)
        these = norm.cdf(shift / np.sqrt(2)).mean(axis=0)
        further = norm.cdf(0.5 / np.sqrt(2 + 0.7**2))  # the mean of A12 over all problems there are
        error = 3 * np.sqrt(0.92 * 0.08 / studies)
        assert ((table["low"] <= these) & (these <= table["high"])).mean() >= 0.92 - error
        assert ((table["further_low"] <= further) & (further <= table["further_high"])).mean() >= 0.92 - error
        assert (table["high"] - table["low"]).mean() < (0.35 if number == 3 else 0.15)


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
