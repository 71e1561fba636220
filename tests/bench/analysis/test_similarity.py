"""Similarity of search: the numbers of a trial by hand, and optimizers that are the same or apart."""

import numpy as np
import pytest
from scipy.spatial.distance import pdist
from scipy.stats import ks_2samp

from bench import BenchError
from bench.analysis.similarity import STAGES, TRAITS, behaviour, similarity


def made(seed, shift=0.0, trials=40, problems=2, numbers=12):
    rng = np.random.default_rng(seed)
    return [rng.standard_normal((trials, numbers)) + shift for _ in range(problems)]


def test_the_numbers_of_a_stage_by_hand():
    points = np.repeat([[0.0, 0.5], [1.0, 0.5]], 8, axis=0)  # a stage of two points: eight of two
    values = np.array([9.0, 5.0] + [5.0] * 13 + [2.0])
    stages = behaviour(points, values, 1.0, 16).reshape(STAGES, len(TRAITS))
    best, median, spread, movement, away, edges = stages[0]
    assert best == pytest.approx(np.log10(4))
    assert median == pytest.approx(np.log10(6))
    assert spread == -12
    assert movement == pytest.approx(np.log10(0.5))  # from the centre
    assert away == -12
    assert edges == 0.5
    assert stages[4, 3] == pytest.approx(0)  # from one side of the box to the other
    assert stages[4, 4] == pytest.approx(0)  # the best point is still on the other side
    assert stages[-1, 0] == pytest.approx(0)


def test_a_trial_that_ended_early_keeps_its_last_stage():
    points, values = np.random.default_rng(0).random((10, 3)), np.arange(10.0)
    stages = behaviour(points, values, 0.0, 80).reshape(STAGES, len(TRAITS))
    assert (stages == stages[0]).all()
    assert np.isfinite(behaviour(points, np.full(10, np.inf), 0.0, 80)).all()


def test_the_distance_is_the_mean_of_scipy_s():
    one, other = made(1, trials=20), made(2, shift=0.3, trials=20)
    found = similarity({"a": one, "b": other})
    pairs = [(x[:10, i], y[:10, i]) for x, y in zip(one, other, strict=True) for i in range(12)]
    assert found.pairs["distance"][0] == pytest.approx(np.mean([ks_2samp(*pair).statistic for pair in pairs]))
    itself = [(x[:10, i], x[10:, i]) for x in one for i in range(12)]
    assert found.distances.loc["a", "a"] == pytest.approx(np.mean([ks_2samp(*pair).statistic for pair in itself]))


def test_twins_are_one_cluster_and_strangers_are_not():
    found = similarity({"a": made(1), "far": made(2, 2.0), "twin": made(3), "farther": made(4, 5.0)})
    assert found.clusters.to_dict() == {"a": 1, "far": 2, "twin": 1, "farther": 3}
    pair = found.pairs.set_index(["first", "second"]).loc[("a", "twin")]
    assert pair["alike"]
    assert pair["distance"] == pytest.approx(pair["floor"], abs=0.05)
    assert abs(found.distances.loc["a", "a"] - pair["floor"]) < 0.05
    apart = pdist(found.places.loc[["a", "twin", "farther"]])
    assert apart[0] < 0.1 < 0.5 < apart[1]


def test_false_separations_are_rare():
    separated = sum(
        similarity({"a": made(2 * seed), "b": made(2 * seed + 1)}).pairs["p"][0] < 0.05 for seed in range(60)
    )
    assert separated <= 9  # of 60 at 5 %: a binomial exceeds this in 0.2 % of cases


def test_identical_behaviour_is_alike():
    same = [np.zeros((20, 5))]
    found = similarity({"a": same, "b": same, "c": same})
    assert set(found.clusters) == {1}
    assert found.stress == 0
    assert (found.places == 0).all(axis=None)


def test_what_cannot_be_compared_is_refused():
    with pytest.raises(BenchError, match="at least two optimizers"):
        similarity({"a": made(1)})
    with pytest.raises(BenchError, match="at least 10 trials"):
        similarity({"a": made(1, trials=9), "b": made(2, trials=9)})
