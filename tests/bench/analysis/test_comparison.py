"""The chance to end lower and the comparison of a chosen optimizer with its rivals: by hand, and as properties."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm, t

from bench.analysis import pairwise_tests
from bench.analysis.comparison import chances, compare, inflation, order, shared, shared_by, wins_all
from bench.analysis.direction import a12, least_p


def drawn(shifts, problems=6, n=15, seed=1):
    """Return runs of optimizers that differ by a shift."""
    rng, index = np.random.default_rng(seed), pd.MultiIndex.from_product([range(problems), list(shifts), range(n)])
    frame = index.to_frame(index=False, name=["problem", "optimizer", "trial"]).assign(status="ok")
    return frame.assign(fun=rng.standard_normal(len(frame)) + frame["optimizer"].map(shifts).to_numpy(dtype=float))


class TestOneNumber:
    def test_on_a_problem_it_is_the_mean_of_a12_over_the_rivals(self, frame_of):
        cells = {("p", "a"): [1.0, 2.0, 6.0], ("p", "b"): [3.0, 3.0], ("p", "c"): [2.0, 5.0, None]}
        found = chances(frame_of(cells)).set_index("optimizer")
        values = {
            name: np.array([np.inf if value is None else value for value in of]) for (_, name), of in cells.items()
        }
        for name, own in values.items():
            expected = np.mean([a12(own, other) for rival, other in values.items() if rival != name])
            assert found.loc[name, "chance"] == pytest.approx(expected)
        assert found["rank"].tolist() == (-found["chance"]).rank().tolist()
        assert found["chance"].sum() == pytest.approx(1.5)

    def test_over_problems_it_is_the_mean_whatever_the_numbers_of_runs(self, frame_of):
        cells = {("p", "a"): [1.0] * 9, ("p", "b"): [2.0] * 9, ("q", "a"): [2.0], ("q", "b"): [1.0], ("r", "a"): [1.0]}
        found = order(chances(frame_of(cells))).set_index("optimizer")
        assert found["problems"].tolist() == [2, 2]  # b has no run on r
        assert found["chance"].tolist() == [0.5, 0.5]
        assert found["place"].tolist() == [1.5, 1.5]
        assert found["first"].tolist() == [1, 1]

    def test_of_pooled_instances_it_is_that_within_each(self, frame_of):
        frame = frame_of({("p", "a"): [1.0, 2.0, 11.0, 12.0], ("p", "b"): [3.0, 4.0, 13.0, 14.0]})
        assert chances(frame.assign(instance=[1, 1, 2, 2] * 2))["chance"].tolist() == [1.0, 0.0]
        assert chances(frame)["chance"].tolist() == [0.75, 0.25]


class TestTheseProblems:
    def test_by_hand(self):
        frame = drawn({"a": 0.0, "b": 0.3})
        (row,) = compare(frame, "a", before=False).to_dict("records")
        pairs = pairwise_tests(frame)
        ratio = pairs["ratio"].mean() / 6
        assert row["chance"] == pytest.approx(pairs["a12"].mean())
        assert row["p"] == pytest.approx(2 * norm.sf(abs(row["chance"] - 0.5) / (0.5 * ratio**0.5)))
        assert (row["problems"], row["level"]) == (6, 0.05)

    def test_of_one_problem_it_is_the_test_of_the_pair(self):
        frame = drawn({"a": 0.0, "b": 0.7, "c": 0.1}, problems=1)
        pairs = pairwise_tests(frame)
        assert compare(frame, "a", before=False)["p"].tolist() == pytest.approx(pairs["p"][:2].tolist())

    @pytest.mark.parametrize("seed", range(6))
    def test_an_interval_holds_a_half_just_where_the_test_is_open(self, seed):
        frame = drawn({"a": 0.0, "b": 0.25, "c": -0.3, "d": 0.0, "e": 0.8}, problems=3, n=4 + 3 * seed, seed=seed)
        for before in (True, False):
            found = compare(frame, "a", before=before)
            apart = (found["low"] > 0.5) | (found["high"] < 0.5)
            assert (apart == (found["outcome"] != "open")).all()
            assert (found["outcome"][found["chance"] > 0.5] != "worse").all()
        pairs = pairwise_tests(frame)
        assert (((pairs["low"] > 0.5) | (pairs["high"] < 0.5)) == pairs["significant"]).all()

    def test_a_subject_shares_its_level_and_a_winner_needs_every_test(self):
        frame = drawn({"a": 0.0, "b": 0.9, "c": 0.9, "d": 0.0})
        subject, leader = compare(frame, "a", before=True), compare(frame, "a", before=False)
        assert subject["level"].tolist() == pytest.approx([0.05 / 3] * 3)
        assert leader["level"].tolist() == [0.05] * 3
        assert subject["outcome"].tolist() == ["better", "better", "open"]
        assert not wins_all(leader)
        assert wins_all(leader[leader["rival"] != "d"])
        assert not wins_all(leader[:0])

    def test_p_is_never_below_that_of_complete_separation(self, frame_of):
        cells = {(problem, name): [float(name == "b") + 0.1 * i for i in range(3)] for problem in "pq" for name in "ab"}
        assert compare(frame_of(cells), "a", before=False)["p"].tolist() == [least_p(6)]


class TestSeeds:
    def test_runs_of_one_seed_on_several_problems_count_as_one(self):
        """Every problem repeats the same runs, so that six problems say as much as one."""
        one = drawn({"a": 0.0, "b": 0.5}, problems=1)
        frame = pd.concat(
            [one.assign(problem=problem, seed=one["trial"] + 100 * (one["optimizer"] == "b")) for problem in range(6)]
        )
        (row,) = compare(frame, "a", before=False).to_dict("records")
        (alone,) = compare(one, "a", before=False).to_dict("records")
        naive = compare(frame.drop(columns="seed"), "a", before=False)["p"].iloc[0]
        assert naive < row["p"]
        assert row["p"] == pytest.approx(2 * t.sf(norm.isf(alone["p"] / 2), 29), rel=0.1)

    def test_the_variance_is_never_smaller_than_that_of_independent_runs(self):
        rng = np.random.default_rng(3)
        samples = [[list(rng.standard_normal((2, 5)))] for _ in range(4)]
        seeds = [[[np.arange(5), np.arange(5, 10)]] for _ in range(4)]
        assert shared(seeds)
        factor, freedom = inflation(samples, seeds)
        assert factor >= 1
        assert freedom == 9

    def test_runs_that_share_seeds_across_problems_are_found(self):
        rows = [("p", "a", 1), ("q", "a", 1), ("p", "b", 2), ("q", "b", 3), ("p", "c", None), ("q", "c", None)]
        assert shared_by(pd.DataFrame(rows, columns=["problem", "optimizer", "seed"])) == ["a"]
