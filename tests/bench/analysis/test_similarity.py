"""Similarity of search: the numbers of a trial by hand, and optimizers that are the same or apart."""

from itertools import combinations

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


def walks(rng, trials, problems=2, numbers=8):
    """Return what one optimizer does: numbers that depend on those before them, with ties."""
    return [rng.standard_normal((trials, numbers)).cumsum(axis=1).round() for _ in range(problems)]


@pytest.mark.sampled(1)
@pytest.mark.parametrize(("optimizers", "trials", "repeats"), [(2, 10, 200), (4, 14, 60)])
def test_false_separations_are_rare(optimizers, trials, repeats):
    rng = np.random.default_rng(1)
    behaviours = ({str(i): walks(rng, trials) for i in range(optimizers)} for _ in range(repeats))
    wrong = sum(not similarity(each).pairs["alike"].all() for each in behaviours)
    assert wrong <= 0.05 * repeats + 3 * (0.05 * 0.95 * repeats) ** 0.5


def test_p_is_the_share_of_all_divisions_that_are_as_far_apart():
    found = similarity({"a": made(1, trials=10), "b": made(2, trials=10, shift=9.0)})
    assert found.pairs["p"][0] == found.least == 1 / 126  # 5 against 5 separated trials; never "< 0.001"
    one, other = (walks(np.random.default_rng(seed), 10, problems=1, numbers=3) for seed in (3, 4))
    both = np.concatenate((one[0][:5], other[0][:5]))
    halves = [list(each) for each in combinations(range(10), 5)]
    far = [
        sum(round(5 * ks_2samp(both[own, i], np.delete(both[:, i], own), method="asymp").statistic) for i in range(3))
        for own in halves
    ]
    assert similarity({"a": one, "b": other}).pairs["p"][0] == pytest.approx(np.mean(np.array(far) >= far[0]))
    assert 0.05 < np.mean(np.array(far) >= far[0]) < 0.95


def test_many_trials_are_divided_at_random_often_enough_for_every_pair_to_count():
    behaviours = {str(i): made(i, shift=5.0 * i, trials=20, problems=1, numbers=3) for i in range(15)}
    found = similarity(behaviours)
    assert found.least == pytest.approx(0.05 / 105 / 2)
    assert (found.pairs["p"] == found.least).all()
    assert not found.pairs["alike"].any()
    assert found.clusters.is_unique
    assert (found.pairs["p"] < 0.01).all()
    assert similarity(behaviours).pairs.equals(found.pairs)


def test_so_few_trials_that_no_pair_can_be_separated_are_said_to_be_few():
    far = {str(i): made(i, shift=9.0 * i, trials=14) for i in range(5)}
    few = similarity({name: [own[:10] for own in each] for name, each in far.items()})
    assert few.least * len(few.pairs) > 0.05
    assert (few.needed, few.pairs["alike"].all()) == (12, True)
    enough = similarity({name: [own[:12] for own in each] for name, each in far.items()})
    assert not enough.pairs["alike"].any()


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
