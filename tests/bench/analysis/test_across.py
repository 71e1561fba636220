"""Across problems: Demšar's published example, against scipy and scikit-posthocs, by hand and as properties."""

from itertools import combinations, product

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import bootstrap, friedmanchisquare, rankdata, wilcoxon

from bench.analysis import pairwise
from bench.analysis.across import (
    average_ranks,
    cliques,
    critical_difference,
    friedman,
    nemenyi,
    normalised_errors,
    probability_of_improvement,
    relative_medians,
    wilcoxon_cliques,
    wilcoxon_tests,
)
from bench.analysis.cells import summarise
from bench.analysis.compare import medians
from bench.analysis.pairwise import a12, holm
from tests.bench.analysis.tables import random_table, table_of

pytestmark = pytest.mark.filterwarnings("error")
INF = float("inf")


class TestDemsarsExample:
    """Demšar 2006, section 3.2.2 and Table 2; the data are his Table 6."""

    def test_average_ranks(self, demsar):
        assert average_ranks(demsar).round(3).tolist() == [3.143, 2.000, 2.893, 1.964]

    def test_friedman_and_iman_davenport(self, demsar):
        # He prints the statistics without the correction for ties, which scipy makes: four of the 14 rows have some.
        n, k = demsar.shape
        chi2 = 12 * n / (k * (k + 1)) * ((average_ranks(demsar) ** 2).sum() - k * (k + 1) ** 2 / 4)
        assert round(chi2, 2) == 9.28
        assert round((n - 1) * chi2 / (n * (k - 1) - chi2), 2) == 3.69
        row = friedman(demsar).iloc[0]
        ties = sum((counts**3 - counts).sum() for counts in (row.value_counts() for _, row in demsar.iterrows()))
        assert row.statistic == pytest.approx(chi2 / (1 - ties / (n * k * (k**2 - 1))))
        assert row.iman_davenport > 3.69
        assert (row.problems, row.optimizers, row.df1, row.df2, row.note) == (14, 4, 3, 39, "")
        assert row.p_iman_davenport < row.p < 0.05

    def test_critical_difference(self):
        assert round(critical_difference(4, 14, 0.05), 2) == 1.25
        assert round(critical_difference(4, 14, 0.10), 2) == 1.12

    @pytest.mark.parametrize(("k", "q05", "q10"), [(2, 1.960, 1.645), (4, 2.569, 2.291), (10, 3.164, 2.920)])
    def test_critical_values(self, k, q05, q10):
        scale = np.sqrt(k * (k + 1) / (6 * 14))
        assert round(critical_difference(k, 14, 0.05) / scale, 3) == q05
        assert round(critical_difference(k, 14, 0.10) / scale, 3) == q10

    def test_groups(self, demsar):
        ranks = average_ranks(demsar)
        assert cliques(ranks, critical_difference(4, 14)) == [("C4.5+m+cf", "C4.5+m", "C4.5+cf", "C4.5")]
        assert cliques(ranks, critical_difference(4, 14, 0.10)) == [
            ("C4.5+m+cf", "C4.5+m", "C4.5+cf"),
            ("C4.5+cf", "C4.5"),
        ]

    def test_signed_ranks(self, demsar):
        # His sums are 93 and 12. Two of the 14 differences are zero: he splits their ranks, as zero_method="zsplit".
        pair = demsar[["C4.5", "C4.5+m"]]
        difference = (pair["C4.5"] - pair["C4.5+m"]).round(4)
        assert wilcoxon(difference, zero_method="zsplit").statistic == 12
        test = wilcoxon_tests(10**pair).iloc[0]  # the logarithm is taken back
        assert (test.scale, test.statistic, test.lower) == ("log10 median", 12, "C4.5+m")
        assert test.significant


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
        assert average_ranks(table).tolist() == pytest.approx([1, 7.5 / 3, 7.5 / 3])
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


class TestRelativeMedians:
    table = table_of([[1, 2], [10, 1000], [5, INF]])

    def test_errors_where_every_optimum_is_known_and_missed(self):
        relative, scale = relative_medians(self.table, {"p0": 0.0, "p1": 0.0, "p2": 4.0, "other": 1.0})
        assert scale == "log10 error"
        assert relative.to_numpy().tolist() == [[0, np.log10(2)], [1, 3], [0, INF]]

    @pytest.mark.parametrize(
        "optima", [None, {}, {"p0": 0.0, "p1": 0.0}, *({"p0": 0.0, "p1": 0.0, "p2": 5.0 - miss} for miss in (0, 1e-14))]
    )
    def test_medians_where_an_optimum_is_unknown_or_reached(self, optima):
        relative, scale = relative_medians(self.table, optima)
        assert scale == "log10 median"
        assert relative.loc["p1"].tolist() == [1, 3]

    def test_shares_of_the_range_where_a_median_is_not_positive(self):
        table = table_of([[-1, 0, 3], [1, INF, 2], [2, 2, 2], [INF, INF, 1], [INF, INF, INF]])
        relative, scale = relative_medians(table)
        assert scale == "share of range"
        assert relative.to_numpy().tolist() == [[0, 0.25, 1], [0, INF, 1], [0, 0, 0], [INF, INF, 0], [INF] * 3]


class TestWilcoxon:
    def test_columns_and_pairs(self):
        tests = wilcoxon_tests(random_table(0))
        columns = ["first", "second", "problems", "statistic", "p", "p_holm", "significant", "lower", "scale", "note"]
        assert list(tests.columns) == columns
        assert list(zip(tests["first"], tests["second"], strict=True)) == list(combinations("abcd", 2))

    @pytest.mark.parametrize("seed", range(3))
    def test_against_scipy(self, seed):
        table = random_table(seed, problems=18)
        tests = wilcoxon_tests(table)
        for test in tests.itertuples():
            difference = np.log10(table[test.first]) - np.log10(table[test.second])
            expected = wilcoxon(difference, method="exact")
            assert (test.statistic, test.p) == pytest.approx((expected.statistic, expected.pvalue))
            upper = wilcoxon(difference, alternative="greater").pvalue
            assert test.lower == (test.second if upper < 0.5 else test.first)
        np.testing.assert_array_equal(tests["p_holm"], holm(tests["p"].to_numpy()))
        np.testing.assert_array_equal(tests["significant"], tests["p_holm"] <= 0.05)

    @pytest.mark.parametrize("seed", range(4))
    def test_ties_and_zeros_against_all_flips_of_the_signs(self, seed):
        rng = np.random.default_rng(seed)
        difference = rng.integers(-2, 5, 9)
        size = rankdata(np.abs(difference))
        flips = np.array(list(product((-1, 1), repeat=9)))
        sums = (flips * np.where(difference == 0, 0, size)).sum(axis=1)
        seen = (np.sign(difference) * size).sum()
        test = wilcoxon_tests(table_of(10.0 ** np.column_stack((difference, np.zeros(9))))).iloc[0]
        assert test.p == pytest.approx(np.mean(np.abs(sums) >= abs(seen)))
        assert test.statistic == (45 - abs(seen)) / 2

    def test_many_tied_problems(self):
        table = random_table(1, problems=40, optimizers=2).round(0) + 1
        tests = wilcoxon_tests(table)
        expected = wilcoxon(np.log10(table["a"] / table["b"]).round(9), zero_method="zsplit")
        assert tests["p"].iloc[0] == pytest.approx(expected.pvalue, abs=0.01)

    def test_rounding_of_the_logarithm_does_not_break_ties(self):
        rows = [[10.0**i, 3 * 10.0**i] for i in range(-3, 4)] + [[3 * 10.0**i, 10.0**i] for i in range(-9, -6)]
        assert wilcoxon_tests(table_of(rows)).iloc[0].statistic == 3 * 5.5

    def test_identical(self):
        test = wilcoxon_tests(table_of([[1, 1], [2, 2]] * 4)).iloc[0]
        assert (test.p, test.p_holm, test.significant, test.lower, test.note) == (1.0, 1.0, False, "", "identical")

    def test_two_failures_are_no_difference(self):
        rows = [[1, 2], [2, 4], [3, 6.1], [4, 8.2], [5, 10.3], [6, 12.4]]
        test = wilcoxon_tests(table_of([*rows, [INF, INF]])).iloc[0]
        assert (test.problems, test.lower, test.note) == (7, "a", "")
        assert test.statistic == 0.5  # half the rank of the problem that both failed
        assert test.p == 2 / 2**6

    def test_one_failure_is_the_largest_difference(self):
        test = wilcoxon_tests(table_of([[1, 2], [2, 4], [3, 6.1], [4, 8.2], [5, 10.3], [INF, 12.4]])).iloc[0]
        assert test.statistic == 6

    @pytest.mark.parametrize(("differing", "note"), [(5, "untestable"), (6, "")])
    def test_too_few_differences_are_untestable(self, differing, note):
        rows = [[i + 1, 2.0**i * 5] for i in range(differing)] + [[1, 1]] * 9
        test = wilcoxon_tests(table_of(rows)).iloc[0]
        assert test.note == note
        assert (test.p == 1.0) == bool(note)
        assert test.lower == "a"

    @pytest.mark.parametrize("n", [63, 64, 65, 100])
    def test_many_problems(self, n):
        table = random_table(2, problems=n, optimizers=2)
        test = wilcoxon_tests(table).iloc[0]
        expected = wilcoxon(np.log10(table["a"] / table["b"]), method="exact")
        assert test.note == ""
        assert (test.statistic, test.p) == pytest.approx((expected.statistic, expected.pvalue))

    def test_on_a_hundred_problems_the_smallest_p_is_that_of_all_signs_alike(self):
        test = wilcoxon_tests(table_of([[i, 2 * i + i**2] for i in range(1, 101)])).iloc[0]
        assert (test.statistic, test.note, test.lower, test.significant) == (0, "", "a", True)
        assert test.p == pytest.approx(2.0**-99, rel=1e-12)

    def test_nothing_to_compare(self):
        assert wilcoxon_tests(table_of([[1], [2]])).empty
        tests = wilcoxon_tests(table_of(np.empty((0, 3))))
        assert tests["note"].tolist() == ["untestable"] * 3
        assert not tests["significant"].any()

    @settings(max_examples=30)
    @given(st.lists(st.lists(st.integers(1, 30) | st.just(INF), min_size=2, max_size=2), min_size=1, max_size=9))
    def test_swapping_the_optimizers_swaps_only_the_favour(self, rows):
        table = table_of(rows)
        test, mirrored = wilcoxon_tests(table).iloc[0], wilcoxon_tests(table[["b", "a"]]).iloc[0]
        assert (test.statistic, test.p, test.lower) == pytest.approx((mirrored.statistic, mirrored.p, mirrored.lower))
        assert 0 < test.p <= test.p_holm <= 1


@pytest.mark.parametrize("seed", range(3))
def test_from_trials(random_frame, seed):
    table = medians(summarise(random_frame(seed, problems=7, failing=0.4)))
    assert table.shape == (7, 4)
    for result in (friedman(table), wilcoxon_tests(table), nemenyi(table)):
        assert not result.filter(regex="^p").isna().any(axis=None)


class TestImprovement:
    def test_by_hand(self, frame_of, one):
        frame = frame_of(
            {
                ("p", "a"): [1.0, 2.0], ("p", "b"): [3.0, 4.0],
                ("q", "a"): [1.0, 3.0], ("q", "b"): [2.0, 2.0],
                ("r", "a"): [1.0, 3.0],
            }
        )  # fmt: skip
        row = one(probability_of_improvement(frame))
        assert (row["first"], row.second, row.problems, row.probability) == ("a", "b", 2, 0.75)
        assert 0.5 <= row.low <= row.probability <= row.high <= 1  # on p, a is always ahead

    def test_the_interval_is_that_of_independent_problems(self, frame_of, one):
        rng = np.random.default_rng(2)
        samples = {(f"p{i}", name): rng.normal(shift, 1, 20) for i in range(4) for name, shift in (("a", 0), ("b", 1))}
        row = one(probability_of_improvement(frame_of(samples)))
        problems = [(samples[f"p{i}", "a"], samples[f"p{i}", "b"]) for i in range(4)]

        def mean_a12(*values, axis=-1):
            pairs = zip(values[::2], values[1::2], strict=True)
            return np.mean([(x[..., :, None] < y[..., None, :]).mean(axis=(-2, -1)) for x, y in pairs], axis=0)

        expected = bootstrap(
            [sample for pair in problems for sample in pair], mean_a12, n_resamples=9_999, batch=500,
            vectorized=True, method="percentile", random_state=np.random.default_rng(3),
        )  # fmt: skip
        assert row.probability == pytest.approx(np.mean([a12(*pair) for pair in problems]))
        assert row.low == pytest.approx(expected.confidence_interval.low, abs=0.005)
        assert row.high == pytest.approx(expected.confidence_interval.high, abs=0.005)

    @pytest.mark.parametrize("seed", range(2))
    def test_the_two_directions_add_up_to_one(self, random_frame, seed):
        frame = random_frame(seed)
        forth = probability_of_improvement(frame)
        frame["optimizer"] = pd.Categorical(frame["optimizer"], list("dcba"))
        back = probability_of_improvement(frame).set_index(["second", "first"])
        for row in forth.itertuples():
            mirrored = back.loc[(row.first, row.second)]
            assert row.probability + mirrored.probability == pytest.approx(1)
            assert (row.low, row.high) == pytest.approx((1 - mirrored.high, 1 - mirrored.low), abs=0.02)
        assert list(zip(forth["first"], forth["second"], strict=True)) == list(combinations("abcd", 2))

    def test_the_seed_decides(self, random_frame):
        frame = random_frame(0)
        pd.testing.assert_frame_equal(probability_of_improvement(frame), probability_of_improvement(frame))
        assert not probability_of_improvement(frame, seed=1).equals(probability_of_improvement(frame))

    def test_failures_are_the_worst_and_rounding_is_a_tie(self, frame_of, one):
        cells = {("p", "a"): [1.0, 1.0], ("p", "b"): [None, None], ("q", "a"): [1.0, 2], ("q", "b"): [1 + 1e-13, 2]}
        assert one(probability_of_improvement(frame_of(cells))).probability == 0.75

    @pytest.mark.parametrize("seed", range(3))
    def test_the_interval_of_many_optimizers_is_close_to_that_of_few(self, random_frame, seed, monkeypatch):
        frame = random_frame(seed)
        few = probability_of_improvement(frame)
        monkeypatch.setattr(pairwise, "RESAMPLED", 1)
        many = probability_of_improvement(frame)
        assert not many["low"].equals(few["low"])
        pd.testing.assert_frame_equal(many.iloc[:, :4], few.iloc[:, :4])
        pd.testing.assert_frame_equal(many[["low", "high"]], few[["low", "high"]], atol=0.03, rtol=0)

    def test_many_optimizers_with_failures_and_single_trials(self, frame_of, monkeypatch):
        monkeypatch.setattr(pairwise, "RESAMPLED", 1)
        cells = {("p", "a"): [1.0, 2.0], ("p", "b"): [None, None], ("p", "c"): [1.5]}
        table = probability_of_improvement(frame_of(cells)).set_index(["first", "second"])
        assert table["probability"].to_dict() == {("a", "b"): 1.0, ("a", "c"): 0.5, ("b", "c"): 0.0}
        assert table["low"].dropna().to_dict() == {("a", "b"): 1.0}

    def test_a_single_trial_leaves_no_interval(self, frame_of, one):
        row = one(probability_of_improvement(frame_of({("p", "a"): [1.0, 2.0], ("p", "b"): [3.0]})))
        assert row.probability == 1.0
        assert np.isnan([row.low, row.high]).all()

    def test_no_problem_with_every_optimizer(self, frame_of, one):
        row = one(probability_of_improvement(frame_of({("p", "a"): [1.0], ("q", "b"): [1.0]})))
        assert row.problems == 0
        assert np.isnan([row.probability, row.low, row.high]).all()

    def test_one_optimizer_and_an_empty_frame(self, frame_of):
        assert probability_of_improvement(frame_of({("p", "a"): [1.0]})).empty
        assert probability_of_improvement(frame_of({})).empty


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


class TestWilcoxonCliques:
    RANKS = pd.Series({"c": 3.0, "a": 1.0, "b": 2.0, "d": 4.0})

    def cliques(self, *apart):
        pairs = [(one, other) for i, one in enumerate("abcd") for other in "abcd"[i + 1 :]]
        significant = [pair in apart or pair[::-1] in apart for pair in pairs]
        first, second = zip(*pairs, strict=True)
        tests = pd.DataFrame({"first": first, "second": second, "significant": significant})
        return wilcoxon_cliques(self.RANKS, tests)

    def test_neighbours_of_which_no_pair_differs_are_joined(self):
        assert self.cliques() == [("a", "b", "c", "d")]
        assert self.cliques(("a", "d")) == [("a", "b", "c"), ("b", "c", "d")]
        assert self.cliques(("d", "a"), ("a", "c"), ("d", "b")) == [("a", "b"), ("b", "c"), ("c", "d")]

    def test_nobody_is_joined_where_all_differ(self):
        every = [(one, other) for one in "abcd" for other in "abcd" if one < other]
        assert self.cliques(*every) == []

    def test_a_group_ends_where_any_of_its_pairs_differs(self):
        assert self.cliques(("b", "c")) == [("a", "b"), ("c", "d")]  # a and c, not neighbours, have no bar
