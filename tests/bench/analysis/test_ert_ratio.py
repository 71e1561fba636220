"""The ratio of expected running times of two optimizers over problems."""

import numpy as np
import pandas as pd
import pytest

from bench.analysis.ert_ratio import ert_ratios


def hits(times, spent=100.0):
    """Return hitting times, by problem and optimizer; infinite for a run that spent its budget without a success."""
    rows = [
        {"problem": problem, "optimizer": label, "trial": number, "evaluations": time, "spent": spent}
        for (problem, label), of_cell in times.items()
        for number, time in enumerate(of_cell)
    ]
    return pd.DataFrame(rows)


def test_the_ratio_is_the_geometric_mean_over_problems():
    times = {("p", "a"): [10, 10], ("p", "b"): [40, 40], ("q", "a"): [20, 20], ("q", "b"): [20, 20]}
    table = ert_ratios(hits(times), "a", ["b"])
    (row,) = table.to_dict("records")
    assert (row["rival"], row["problems"], row["bounded"]) == ("b", 2, 0)
    assert row["ratio"] == pytest.approx(2.0)
    assert (row["low"], row["high"]) == (pytest.approx(2.0), pytest.approx(2.0))


def test_a_problem_that_one_does_not_solve_enters_by_a_bound_and_one_that_neither_solves_is_left_out():
    never = [np.inf, np.inf]
    table = ert_ratios(
        hits({("p", "a"): [10, 10], ("p", "b"): never, ("q", "a"): never, ("q", "b"): never}), "a", ["b"]
    )
    (row,) = table.to_dict("records")
    assert (row["problems"], row["bounded"]) == (1, 1)
    assert row["ratio"] == pytest.approx(200 / 10)
    assert row["high"] == np.inf
    assert row["low"] == pytest.approx(20)
    turned = ert_ratios(hits({("p", "a"): never, ("p", "b"): [10, 10]}), "a", ["b"]).iloc[0]
    assert (turned["low"], turned["ratio"]) == (0, pytest.approx(10 / 200))
    each = {("p", "a"): never, ("p", "b"): [10, 10], ("q", "a"): [10, 10], ("q", "b"): never}
    assert ert_ratios(hits(each), "a", ["b"])[["low", "high"]].isna().all(axis=None)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("rates", [(0.9, 0.4), (1.0, 1.0)])
def test_intervals_hold_the_true_ratio_in_95_percent(rates):
    rng, covered = np.random.default_rng(3), 0
    true = np.divide(*(np.exp(0.7**2 / 2) * 20 + (1 - rate) / rate * 100 for rate in rates[::-1]))
    for _ in range(200):
        times = {
            (problem, label): np.where(rng.random(12) < rate, rng.lognormal(np.log(20), 0.7, 12), np.inf)
            for problem in "pqrs" for label, rate in zip("ab", rates, strict=True)
        }  # fmt: skip
        (row,) = ert_ratios(hits(times), "a", ["b"]).to_dict("records")
        covered += row["low"] <= true <= row["high"]
    assert 183 <= covered <= 200
