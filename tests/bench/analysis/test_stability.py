"""Ranks over the number of trials: those of the first trials, as the standings rank them, and of subsets."""

import numpy as np
import pytest

from bench.analysis.cells import summarise
from bench.analysis.pairwise import pairwise_tests
from bench.analysis.stability import rank_stability
from bench.analysis.standings import mean_ranks, standings


def test_the_ranks_are_the_standings_of_the_first_trials(random_frame):
    frame = random_frame(5, problems=3, trials=14, failing=0.1)
    found = rank_stability(frame)
    assert found["trials"].min() == 3
    assert found["trials"].max() == 14
    for trials, own in found.groupby("trials"):
        early = frame[frame["trial"] < trials]
        expected = mean_ranks(standings(summarise(early), pairwise_tests(early)))
        assert own.set_index("optimizer")["rank"].to_dict() == pytest.approx(expected.to_dict())


def test_bands_hold_the_curve_and_end_in_a_point(random_frame):
    found = rank_stability(random_frame(6, trials=20))
    assert (found["low"] <= found["rank"]).all()
    assert (found["rank"] <= found["high"]).all()
    last = found[found["trials"] == 20]
    assert (last["low"] == last["high"]).all()
    assert (found[found["trials"] == 3]["high"] > found[found["trials"] == 3]["low"]).any()


def test_a_smaller_cell_enters_with_all_it_has(frame_of):
    rng = np.random.default_rng(1)
    values = rng.random(12)
    found = rank_stability(frame_of({("p", "a"): values, ("p", "b"): 9 + rng.random(4)}))
    assert found["trials"].max() == 12
    assert found.groupby("optimizer")["rank"].unique().map(list).to_dict() == {"a": [1.0], "b": [2.0]}


def test_nothing_to_draw(frame_of):
    assert rank_stability(frame_of({("p", "a"): [1.0] * 9})).empty
    assert rank_stability(frame_of({("p", "a"): [1.0] * 3, ("p", "b"): [2.0] * 3})).empty
    assert rank_stability(frame_of({("p", "a"): [1.0] * 9, ("q", "b"): [2.0] * 9})).empty
    assert rank_stability(frame_of({("p", "a"): [1.0]}).head(0)).empty


def test_instances_take_turns(frame_of):
    # pooled: the first five trials are of instance 1, on which a is better; over both it is a tie
    a, b = [0.0] * 5 + [9.0] * 5, [1.0] * 5 + [8.0] * 5
    frame = frame_of({("p", "a"): a, ("p", "b"): b})
    frame = frame.assign(instance=np.where(frame["trial"] < 5, 1, 2))
    found = rank_stability(frame).set_index(["optimizer", "trials"])["rank"]
    assert found["a", 4] == found["b", 4] == 1.5
