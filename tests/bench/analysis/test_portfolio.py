"""Virtual and single best, sets and Shapley values of optimizers whose scores are known."""

from itertools import permutations

import numpy as np
import pandas as pd
import pytest

from bench import BenchError
from bench.analysis.portfolio import HalfScores, best_gap, portfolio_of, shapley, student, target_shares


def scores_of(values, names="abcdefghijklmnopqrstuvwxyz"):
    """Return scores from an array, (problems, optimizers, trials)."""
    problem, optimizer, trial = (each.ravel() for each in np.indices(values.shape))
    labels = np.array(list(names), dtype=object)
    problems = np.array([f"p{number}" for number in range(len(values))], dtype=object)
    return pd.DataFrame(
        {"problem": problems[problem], "optimizer": labels[optimizer], "trial": trial, "score": values.ravel()}
    )


def apart(scores):
    return {problem: problem for problem in scores["problem"]}


@pytest.fixture(scope="module")
def complementary():
    """Return scores of a, good on four problems, b, good on four others, and c, bad on all of them."""
    values = np.full((8, 3, 6), 0.2) + 0.01 * np.random.default_rng(0).standard_normal((8, 3, 6))
    values[:4, 0] += 0.6
    values[4:, 1] += 0.6
    return scores_of(values)


def test_complementary_optimizers_make_a_gap_of_their_difference(complementary, one):
    gap = one(portfolio_of(complementary, apart(complementary)).gap)
    assert gap["shown"]
    assert gap["gap"] == pytest.approx(0.3, abs=0.02)
    assert gap["virtual_score"] == pytest.approx(0.8, abs=0.02)


def test_the_smallest_set_holds_the_complementary_ones(complementary):
    sets = portfolio_of(complementary, apart(complementary)).sets
    assert sets["size"].to_list() == [1, 2]
    assert sets["optimizers"].to_list()[-1] == ("a", "b")
    assert sets["ratio"].to_list()[-1] == pytest.approx(1, abs=0.01)


def test_what_each_adds_and_how_often_it_is_taken_show_the_useless_one(complementary):
    members = portfolio_of(complementary, apart(complementary)).members.set_index("optimizer")
    assert members["chosen"].to_dict() == pytest.approx({"a": 0.5, "b": 0.5, "c": 0})
    assert members["adds"].to_dict() == pytest.approx({"a": 0.3, "b": 0.3, "c": 0}, abs=0.02)
    assert members["shapley"]["c"] < 0.1 < members["shapley"]["a"]


def test_equal_optimizers_have_a_gap_by_chance_on_the_same_trials_alone(one):
    scores = scores_of(np.random.default_rng(3).normal(0.5, 0.1, (24, 6, 10)))
    gap = one(portfolio_of(scores, apart(scores)).gap)
    whole = HalfScores.of(scores, apart(scores)).whole
    assert whole.max(axis=1).mean() - whole.mean(axis=0).max() > 0.03
    assert abs(gap["gap"]) < 0.01
    assert gap["low"] < 0 < gap["high"]
    assert not gap["shown"]


def test_no_more_claims_among_equal_optimizers_than_the_level_allows():
    rng, claims = np.random.default_rng(5), 0
    for _ in range(60):
        scores = scores_of(rng.normal(0.5, 0.1, (8, 4, 6)))
        claims += best_gap(HalfScores.of(scores, apart(scores)))["shown"].iloc[0]
    assert claims <= 6  # more are a chance of 0.1 % at 2.5 %


def test_ties_are_shared_and_make_no_gap(one):
    scores = scores_of(np.full((4, 3, 4), 0.5))
    found = portfolio_of(scores, apart(scores))
    gap = one(found.gap)
    assert (gap["gap"], gap["low"], gap["high"], gap["shown"]) == (0, 0, 0, False)
    assert found.members["chosen"].to_list() == pytest.approx([1 / 3] * 3)
    assert found.members["shapley"].to_list() == pytest.approx([1 / 6] * 3)


def test_trials_that_reach_nothing_have_no_ratio_but_1(one):
    scores = scores_of(np.zeros((4, 3, 4)))
    found = portfolio_of(scores, apart(scores))
    assert found.sets["ratio"].to_list() == [1]
    assert (found.members["shapley"] == 0).all()
    assert not one(found.gap)["shown"]


def test_one_optimizer_is_the_virtual_best(one):
    scores = scores_of(np.random.default_rng(0).random((4, 1, 4)))
    found = portfolio_of(scores, apart(scores))
    assert one(found.gap)["gap"] == 0
    assert one(found.sets)["optimizers"] == ("a",)
    assert one(found.members)["shapley"] == pytest.approx(one(found.gap)["virtual_score"])


def test_one_problem_has_no_interval(complementary, one):
    own = complementary[complementary["problem"] == "p0"]
    gap = one(portfolio_of(own, {}).gap)
    assert np.isnan(gap["low"])
    assert not gap["shown"]


def test_dimensions_of_one_function_count_once(complementary, one):
    blocks = {f"p{number}": "f" if number < 4 else f"p{number}" for number in range(8)}
    found = portfolio_of(complementary, blocks)
    assert one(found.gap)["functions"] == 5
    assert one(found.gap)["single"] == "b"
    assert found.members["chosen"].to_list() == pytest.approx([0.2, 0.8, 0])


def test_cells_of_different_sizes_are_halved_each():
    scores = scores_of(np.random.default_rng(1).random((4, 2, 5)))
    fewer = scores[~((scores["optimizer"] == "b") & (scores["trial"] > 2))]
    halves = HalfScores.of(fewer, {})
    assert np.isfinite(halves.choose).all()
    both = halves.choose[0, 0, 1] * 1 + halves.score[0, 0, 1] * 2  # of 3 trials, one chooses and two score
    assert both / 3 == pytest.approx(halves.whole[0, 1])


def test_problems_with_a_single_trial_are_left_out(complementary, one):
    cut = complementary[(complementary["problem"] != "p1") | (complementary["trial"] == 0)]
    assert one(portfolio_of(cut, {}).gap)["problems"] == 7
    with pytest.raises(BenchError, match="every optimizer has two trials"):
        portfolio_of(complementary[complementary["trial"] == 0], {})


# Shapley values


def by_orders(choose, score):
    """Return the Shapley values on one problem as the mean over all orders of what each optimizer adds."""
    added, count = np.zeros(len(choose)), 0
    for order in permutations(range(len(choose))):
        before, count = 0.0, count + 1
        for place in range(1, len(order) + 1):
            held = list(order[:place])
            after = score[held][choose[held] == choose[held].max()].mean()
            added[order[place - 1]] += after - before
            before = after
    return added / count


@pytest.mark.parametrize("count", [1, 2, 3, 4, 6])
@pytest.mark.parametrize("levels", [1, 2, 3, 1000])
def test_values_are_those_over_all_orders_also_with_ties(count, levels):
    rng = np.random.default_rng(count)
    choose, score = rng.integers(levels, size=count).astype(float), rng.random(count)
    assert shapley(choose[np.newaxis], score[np.newaxis])[0] == pytest.approx(by_orders(choose, score))


def test_values_of_each_problem_stand_alone():
    choose, score = np.random.default_rng(0).integers(3, size=(2, 4, 5)).astype(float)
    each = [shapley(choose[[problem]], score[[problem]])[0] for problem in range(4)]
    assert shapley(choose, score) == pytest.approx(np.array(each))


def test_the_values_of_optimizers_sum_to_the_score_of_the_virtual_best(one):
    scores = scores_of(np.random.default_rng(2).random((6, 5, 4)))
    found = portfolio_of(scores, apart(scores))
    assert found.members["shapley"].sum() == pytest.approx(one(found.gap)["virtual_score"])


def test_the_values_of_many_optimizers_sum_to_the_score_of_the_virtual_best_too(one):
    scores = scores_of(np.random.default_rng(6).random((5, 16, 4)).round(1))  # with ties
    found = portfolio_of(scores, {})
    assert found.members["shapley"].sum() == pytest.approx(one(found.gap)["virtual_score"])


def test_adding_one_at_a_time_finds_the_sets_of_all_where_optimizers_are_complementary(monkeypatch):
    values = np.full((9, 4, 6), 0.2) + 0.01 * np.random.default_rng(0).standard_normal((9, 4, 6))
    for member, problems in enumerate((slice(0, 4), slice(4, 7), slice(7, 9))):
        values[problems, member] += 0.6
    scores = scores_of(values)
    exact = portfolio_of(scores, {}).sets
    monkeypatch.setattr("bench.analysis.portfolio.MOST_EXACT", 2)
    added = portfolio_of(scores, {}).sets
    assert [set(each) for each in added["optimizers"]] == [{"a"}, {"a", "b"}, {"a", "b", "c"}]
    assert added["score"].to_list() == exact["score"].to_list()


def test_all_sets_of_a_size_are_compared_where_adding_one_misses_the_best(monkeypatch):
    values = np.full((8, 3, 4), 0.2)
    values[:4, 0] = values[4:, 1] = 0.8  # together the best on each problem
    values[:, 2] = 0.6  # alone the best
    scores = scores_of(values)
    assert portfolio_of(scores, {}).sets["optimizers"].to_list() == [("c",), ("a", "b")]
    monkeypatch.setattr("bench.analysis.portfolio.MOST_EXACT", 2)
    assert portfolio_of(scores, {}).sets["optimizers"].to_list() == [("c",), ("c", "a"), ("c", "a", "b")]


# Scores and intervals


def test_a_score_is_the_share_of_targets_within_the_budget_less_the_charge():
    hits = pd.DataFrame(
        {
            "problem": ["p"] * 6, "optimizer": ["a"] * 3 + ["b"] * 3, "trial": 0, "tau": [3, 2, 1] * 2,
            "evaluations": [1, 50, 100, np.inf, np.inf, np.inf],
        }
    )  # fmt: skip
    assert target_shares(hits, {"p": 100})["score"].to_list() == [1, 0]
    assert target_shares(hits, {"p": 99})["score"].to_list() == pytest.approx([2 / 3, 0])
    assert target_shares(hits, {"p": 99}, {"p": 50})["score"].to_list() == pytest.approx([1 / 3, 0])
    assert target_shares(hits, {"q": 99}).empty


def test_the_interval_is_students():
    mean, low, high = student([1.0, 2.0, 3.0, 4.0])
    assert mean == 2.5
    assert high - mean == pytest.approx(3.182446 * np.sqrt(5 / 3) / 2)  # t of 3 degrees of freedom, from a table
    assert mean - low == pytest.approx(high - mean)
    assert np.isnan(student([1.0])[1:]).all()
