"""Practical equality: against baycomp's signed-rank test, the eight schools, and cells whose answer is known.

The numbers of baycomp 1.0.3 come from ``SignedRankTest.probs(zeros(12), k * DIFFERENCES, 1, nsamples=50000)``.
"""

import numpy as np
import pytest
from scipy.stats import norm

from bench.analysis.equivalence import FAR, differences, hierarchical, in_ropes, probabilities, signed_rank

DIFFERENCES = np.array([-3.1, -2.2, 0.4, -0.3, 0.9, -1.6, 2.4, -0.7, -1.2, 0.1, -2.8, 1.3])
BAYCOMP = {1.0: (0.2054, 0.7913, 0.0033), 0.5: (0.00146, 0.99854, 0.0), 0.25: (0.0, 1.0, 0.0)}
SCHOOLS = np.array([28.0, 8, -3, 7, -1, 1, 18, 12]), np.array([15.0, 10, 16, 11, 9, 11, 10, 18])


@pytest.mark.parametrize("scale", BAYCOMP)
def test_the_signed_rank_test_is_baycomp_s(scale):
    assert signed_rank(scale * DIFFERENCES) == pytest.approx(BAYCOMP[scale], abs=0.012)
    assert signed_rank(-scale * DIFFERENCES) == pytest.approx(BAYCOMP[scale][::-1], abs=0.012)


def test_the_hierarchy_is_that_of_the_eight_schools():
    """Integrate the posterior of the eight schools on a plain grid of mean and spread, without any draw."""
    z, errors = SCHOOLS[0] / 5, SCHOOLS[1] / 5  # a rope of 5 points
    mean, spread = np.meshgrid(np.linspace(-12, 18, 600) / 5, np.linspace(1e-3, 60, 1200) / 5, indexing="ij")
    log = sum(norm.logpdf(y, mean, np.hypot(spread, s)) for y, s in zip(z, errors, strict=True))
    mass = np.exp(log - log.max())
    left, right = norm.cdf((-1 - mean) / spread), norm.sf((1 - mean) / spread)
    winner = np.argmax([left, 1 - left - right, right], axis=0)
    exact = [float(mass[winner == each].sum() / mass.sum()) for each in range(3)]
    assert hierarchical(z, errors) == pytest.approx(exact, abs=0.015)
    assert exact[2] > 0.5


def test_the_errors_of_the_problems_count():
    z = np.array([2.0, 2.1, 1.9, 2.0])
    assert hierarchical(z, np.full(4, 0.1))[2] > 0.98
    assert hierarchical(z, np.full(4, 5.0))[2] < 0.8


def test_equal_medians_within_the_rope_are_equivalent(frame_of):
    rng = np.random.default_rng(1)
    cells = {("p", name): 10 + 0.1 * rng.standard_normal(30) + shift for name, shift in (("a", 0), ("b", 0), ("c", 5))}
    table = differences(frame_of(cells), 0.5).set_index(["first", "second"])
    assert table["equivalent"].to_dict() == {("a", "b"): True, ("a", "c"): False, ("b", "c"): False}
    assert not differences(frame_of(cells), 0.01)["equivalent"].any()
    assert not table["wide"].any()
    row = table.loc[("a", "c")]
    assert row["low"] < row["difference"] < row["high"]
    assert row["difference"] == pytest.approx(np.median(cells["p", "a"]) - np.median(cells["p", "c"]))
    assert row["error"] == pytest.approx(0.1 * np.sqrt(2 * np.pi / 2 / 30), rel=0.5)  # of a median, twice
    relative = differences(frame_of(cells), "5%").set_index(["first", "second"])
    assert relative["equivalent"].to_dict() == table["equivalent"].to_dict()
    assert relative.loc[("a", "c"), "rope"] == pytest.approx(0.05 * np.median(cells["p", "a"]))


def test_a_wide_spread_is_no_proof_of_equality(frame_of):
    rng = np.random.default_rng(2)
    cells = {("p", name): rng.standard_normal(10) for name in "ab"}
    assert not differences(frame_of(cells), 0.3)["equivalent"].any()


def test_the_false_equivalences_of_a_pair_at_the_edge_of_the_rope_are_rare(frame_of):
    rng, wrong = np.random.default_rng(3), 0
    for _ in range(80):
        cells = {("p", "a"): rng.standard_normal(30), ("p", "b"): 1.0 + rng.standard_normal(30)}
        wrong += int(differences(frame_of(cells), 1.0)["equivalent"].iloc[0])
    assert wrong <= 10  # of 80 at 5 %: a binomial exceeds this in 0.2 % of cases


def test_odd_cells(frame_of):
    solved = differences(frame_of({("p", name): [0.0] * 8 for name in "ab"}), "1%")
    assert solved["equivalent"].all()
    few = differences(frame_of({("p", name): [0.0] * 5 for name in "ab"}), 1.0)
    assert not few["equivalent"].any()
    assert few["low"].isna().all()
    failed = differences(frame_of({("p", "a"): [None] * 8, ("p", "b"): [1.0] * 8}), 1.0)
    assert np.isposinf(failed["difference"]).all()
    assert not failed["equivalent"].any()
    assert differences(frame_of({("p", name): [None] * 8 for name in "ab"}), 1.0)["difference"].eq(0).all()
    assert differences(frame_of({("p", "a"): [1.0] * 8, ("q", "b"): [1.0] * 8}), 1.0).empty
    wide = differences(frame_of({("p", "a"): [1.0, 2.0] * 4, ("p", "b"): [1.5] * 8}), 9.0)
    assert wide["wide"].all()


def test_differences_are_counted_in_ropes():
    found = in_ropes(np.array([1.0, -2.0, 0.0, np.inf, 1.0]), np.array([2.0, 1.0, 0.0, 1.0, 0.0]))
    assert list(found) == [0.5, -2.0, 0.0, FAR, FAR]


def test_probabilities_of_a_clear_winner_and_of_twins(frame_of):
    rng, cells = np.random.default_rng(4), {}
    for number in range(10):
        for name, shift in (("a", 0), ("b", 0), ("c", 3)):
            cells[f"p{number}", name] = shift + 0.05 * rng.standard_normal(12)
    found = probabilities(differences(frame_of(cells), 1.0)).set_index(["first", "second"])
    assert found.loc[("a", "b"), ["equal", "equal_h"]].min() > 0.99
    assert found.loc[("a", "c"), ["first_better", "first_better_h"]].min() > 0.99
    assert found[["first_better", "equal", "second_better"]].sum(axis=1).tolist() == pytest.approx([1, 1, 1])
    one = probabilities(differences(frame_of({key: own for key, own in cells.items() if key[0] == "p1"}), 1.0))
    assert one["equal_h"].isna().all()
