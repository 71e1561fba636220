"""Instances as strata: which trials are compared with which, and what that shows."""

import numpy as np
import pytest

from bench.analysis import chances, pairwise_tests
from bench.analysis.direction import a12
from bench.analysis.noninferiority import noninferiority
from bench.analysis.strata import strata


def frame_with(frame_of, values, instances):
    """Return a frame of one problem with these values and these instances of the trials of each optimizer."""
    frame = frame_of({("p", name): list(own) for name, own in values.items()})
    return frame.assign(instance=[each for name in values for each in instances[name]])


@pytest.fixture
def apart(frame_of):
    """Four instances, each far harder than the one before; on each, a is lower."""
    rng = np.random.default_rng(0)
    base = np.repeat([0.0, 100.0, 200.0, 300.0], 4)
    values = {"a": rng.normal(size=16) + base, "b": rng.normal(2, 1, 16) + base}
    return frame_with(frame_of, values, {name: np.repeat(range(4), 4) for name in values})


def test_shared_instances_with_two_trials_or_more_are_strata(apart):
    found = strata(apart)["p"]
    assert [[len(own) for own in each] for each in found] == [[4, 4]] * 4
    assert found[0][0].tolist() == apart["fun"][:4].tolist()
    assert [len(own) for own in strata(apart.drop(columns="instance"))["p"][0]] == [16, 16]


def test_a12_is_the_mean_of_that_within_instances(apart):
    (row,) = pairwise_tests(apart).to_dict("records")
    values = apart["fun"].to_numpy()
    within = [a12(values[i : i + 4], values[16 + i : 20 + i]) for i in range(0, 16, 4)]
    assert row["a12"] == pytest.approx(np.mean(within))
    assert row["lower"] == "a"
    assert pairwise_tests(apart.drop(columns="instance"))["lower"].tolist() == [""]  # across instances, it is hidden
    assert row["n_first"] == 16
    assert chances(apart)["rank"].tolist() == [1, 2]


def test_the_gate_compares_within_instances(apart):
    assert noninferiority(apart, "a", "b").outcome == "worse"
    assert noninferiority(apart.drop(columns="instance"), "a", "b").outcome == "undecided"
    assert noninferiority(apart, "a", "b").problems["n_old"].tolist() == [16]


@pytest.mark.sampled(1)
@pytest.mark.parametrize("variance", [0.8, 0.5, 0.0])
def test_a_difference_between_instances_is_no_difference_between_optimizers(frame_of, variance):
    rng, claims = np.random.default_rng(1), 0
    for _ in range(60):
        base = np.repeat(rng.normal(0, variance**0.5, 5), 5)
        values = {name: base + rng.normal(0, (1 - variance) ** 0.5, 25) for name in "ab"}
        frame = frame_with(frame_of, values, {name: np.repeat(range(5), 5) for name in values})
        claims += int(pairwise_tests(frame)["significant"].sum())
    assert claims <= 9  # 60 studies at 0.05
