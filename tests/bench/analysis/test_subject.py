"""A subject against each of its rivals: which pairs are tested, and how its pairs are read."""

import numpy as np
import pandas as pd
import pytest

from bench.analysis import across_problems, pairwise_tests, summarise
from bench.analysis.pairwise import holm
from bench.analysis.subject import seen_from, signs_of

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


def test_the_signs_are_those_of_the_subject():
    pairs = pairwise_tests(WORSE, subject="b")
    signs = signs_of(summarise(WORSE), pairs, "b").pivot(index="problem", columns="optimizer", values="sign")
    assert set(signs["a"]) == {"−"}
    assert set(signs["b"]) == {""}
    assert set(signs["c"]) == {"="}
