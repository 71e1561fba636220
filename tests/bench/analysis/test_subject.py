"""A subject against each of its rivals: which pairs are tested, and how its pairs are read."""

import numpy as np
import pandas as pd
import pytest

from bench.analysis import across_problems, pairwise_tests, summarise
from bench.analysis.error_rates import Levels, claims, levels, rates_of_equals
from bench.analysis.pairwise import holm
from bench.analysis.subject import in_parts, outcome, seen_from, signs_of

EARLIER = pd.DataFrame({"share": [0.1], "optimizer": ["c"], "probability": [0.2], "p": [1e-9], "shown": [False]})


def frame(shifts, problems=("p", "q", "r", "s"), trials=12, seed=1):
    """Return trials of normal values; ``shifts`` are the means of each optimizer, one or one a problem."""
    rng = np.random.default_rng(seed)
    rows = [
        (problem, optimizer, trial, "ok", value)
        for place, problem in enumerate(problems)
        for optimizer, shift in shifts.items()
        for trial, value in enumerate(rng.normal(np.broadcast_to(shift, len(problems))[place], 1, trials))
    ]
    return pd.DataFrame(rows, columns=["problem", "optimizer", "trial", "status", "fun"])


WORSE = frame({"a": 0.0, "b": 3.0, "c": 3.0})


def test_only_pairs_of_the_subject_are_hypotheses():
    every, own = pairwise_tests(WORSE), pairwise_tests(WORSE, subject="b")
    with_b = own[own["p_holm"].notna()]
    assert set(zip(with_b["first"], with_b["second"], strict=True)) == {("a", "b"), ("b", "c")}
    assert with_b["p_holm"].to_numpy() == pytest.approx(holm(with_b["p"].to_numpy()))
    assert own["p"].tolist() == every["p"].tolist()
    others = own[own["p_holm"].isna()]
    assert not others[["significant", "testable"]].to_numpy().any()
    assert set(others["lower"]) == {""}


def test_over_all_problems_the_adjustment_is_over_the_rivals():
    tests = across_problems(pairwise_tests(WORSE, subject="a"), subject="a").set_index(["first", "second"])
    assert tests["p_holm"].notna().tolist() == [True, True, False]
    assert tests["significant"].tolist() == [True, True, False]
    equals = frame({"a": 0.0, "b": 0.0, "c": 0.0}, trials=5)
    one, all_pairs = (
        across_problems(pairwise_tests(equals), subject=name).set_index(["first", "second"]) for name in ("a", "")
    )
    assert one.loc[("a", "b"), "joint_low"] > all_pairs.loc[("a", "b"), "joint_low"]  # fewer intervals hold together


def test_pairs_are_seen_from_either_side():
    tests = across_problems(pairwise_tests(WORSE))
    row = tests.set_index(["first", "second"]).loc[("a", "c")]
    turned = seen_from(tests, "c").set_index("second").loc["a"]
    assert turned["probability"] == pytest.approx(1 - row["probability"])
    assert (turned["low"], turned["high"]) == pytest.approx((1 - row["high"], 1 - row["low"]))


@pytest.mark.parametrize(
    ("probability", "significant", "said"),
    [
        (0.9, True, "better"),
        (0.1, True, "worse"),
        (0.9, False, "open"),
        (0.5, True, "open"),
        (float("nan"), False, "open"),
    ],
)
def test_an_outcome_needs_a_test(probability, significant, said):
    assert outcome(probability, significant) == said


def test_the_signs_are_those_of_the_subject():
    pairs = pairwise_tests(WORSE, subject="b")
    signs = signs_of(summarise(WORSE), pairs, "b").pivot(index="problem", columns="optimizer", values="sign")
    assert set(signs["a"]) == {"−"}
    assert set(signs["b"]) == {""}
    assert set(signs["c"]) == {"="}


def test_parts_show_where_the_subject_differs_from_its_mean():
    mixed = frame({"a": 0.0, "b": [3.0, 3.0, -3.0, -3.0], "c": 0.0})
    parts = {("class", "easy"): ["p", "q"], ("class", "hard"): ["r", "s"]}
    table = in_parts(pairwise_tests(mixed), parts, EARLIER, "a", 0.01)
    found = table.set_index(["part", "rival"])["outcome"].to_dict()
    assert found == {
        ("easy", "b"): "better", ("easy", "c"): "open", ("hard", "b"): "worse", ("hard", "c"): "open",
        ("10%", "c"): "better",
    }  # fmt: skip
    assert table["p_holm"].to_numpy() == pytest.approx(holm(table["p"].to_numpy(dtype=float)))


def test_a_subject_that_was_chosen_of_many_pays_for_the_choice():
    pairs, parts = pairwise_tests(WORSE), {("class", "all"): list("pqrs")}
    named = in_parts(pairs, parts, EARLIER.head(0), "a", 0.01)
    chosen = in_parts(pairs, parts, EARLIER.head(0), "a", 0.01, subjects=10)
    assert chosen["p_holm"].to_numpy() == pytest.approx(np.minimum(5 * named["p_holm"], 1))


def test_no_part_and_no_smaller_budget_is_an_empty_table():
    assert in_parts(pairwise_tests(WORSE), {}, EARLIER.head(0), "a", 0.01).empty


@pytest.mark.parametrize(("k", "problems", "trials"), [(5, 8, 8), (5, 1, 15)])
def test_false_claims_of_a_subject_are_as_rare_as_the_level(k, problems, trials):
    rng = np.random.default_rng(1)
    level = levels([trials] * problems, k - 1, (k - 1) * problems)
    pools = [[rng.normal(size=trials * k)] for _ in range(problems)]
    parts = [list(range(0, problems, 2)), list(range(1, problems, 2))] if problems > 1 else []
    rates = rates_of_equals(pools, k, level, parts=parts)
    assert rates.any <= 0.05 + 4 * np.sqrt(0.05 * 0.95 / rates.studies)


def test_a_claim_on_a_part_is_found_where_it_is_true():
    rng = np.random.default_rng(1)
    values = rng.standard_normal((4, 3, 50, 15))
    values[:2, 1] += 2.0
    values[2:, 1] -= 2.0
    studies = [[list(of)] for of in values]
    level = levels([15] * 4, 2, 8)
    _, over_all, in_part = claims(studies, level, parts=[[0, 1], [2, 3]])
    assert in_part.all()
    assert over_all.mean() < 0.2


def test_a_level_passes_on_to_parts_where_every_test_over_all_problems_rejects():
    level = Levels(0.01, 0.035, 0.005)
    assert level.in_parts([False, True]).tolist() == pytest.approx([0.005, 0.04])
    values = np.random.default_rng(1).standard_normal((8, 3, 200, 15))
    values[:2, 1:] += 0.7
    shut = claims([[list(of)] for of in values], level, parts=[[0, 1]])[2].mean()
    values[2:, 1:] += 2.0  # on the other problems, which opens the gate
    _, over_all, opened = claims([[list(of)] for of in values], level, parts=[[0, 1]])
    assert over_all.all()
    assert opened.mean() > shut + 0.2
