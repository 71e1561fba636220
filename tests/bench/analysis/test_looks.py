"""What declared looks decide: by hand on separated cells, from the trials before a look alone, and at which level."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import ks_2samp

from bench.analysis.looks import at_looks, blind_looks, decide
from bench.analysis.pairwise import holm, ks_tests, pairwise_tests
from bench.analysis.sequential import levels, repeated_p

LOOKS = (8, 12, 20)


def cell(low, n, seed=0):
    return (low + np.random.default_rng(seed).random(n)).tolist()


def test_separated_cells_stop_at_the_first_look_that_can_see_it(frame_of):
    # a and b never differ; c is separated from both, which 12 trials can show at the level of that look and 8 cannot
    frame = frame_of({("p", "a"): cell(0, 20, 1), ("p", "b"): cell(0, 20, 2), ("p", "c"): cell(5, 20, 3)})
    found = decide(frame, LOOKS)
    first, second = (
        3 * repeated_p(ks_2samp(range(n), range(50, 50 + n)).pvalue, LOOKS, i) for i, n in enumerate((8, 12))
    )
    assert first > 0.05 > second
    assert found.stopped == {("p", "c"): 12}
    assert found.reached == {"p": 20}
    pairs = found.pairs.set_index(["first", "second"])
    assert pairs.loc[("a", "c"), "look"] == pairs.loc[("b", "c"), "look"] == 12
    assert pairs.loc[("a", "c"), "p"] == pytest.approx(second / 3)
    tested = at_looks(pairwise_tests(frame), found)
    assert tested["significant"].tolist() == [False, True, True]
    np.testing.assert_allclose(tested["p_holm"], holm(tested["p"].to_numpy()))
    assert tested["a12"].tolist() == pairwise_tests(frame)["a12"].tolist()


def test_decisions_follow_from_the_trials_before_a_look_alone(frame_of):
    rng = np.random.default_rng(4)
    values = {(f"p{i}", f"o{j}"): rng.normal(3.0 * (j // 2) + 0.5 * i * j, 1, 20) for i in range(4) for j in range(4)}
    frame = frame_of({key: [None if i == 5 else each for i, each in enumerate(own)] for key, own in values.items()})
    whole = decide(frame, LOOKS)
    assert set(whole.stopped.values()) <= set(LOOKS)
    assert len(whole.stopped) > 3
    mixed = frame.iloc[rng.permutation(len(frame))].sort_values("trial", kind="stable")
    assert dict(decide(mixed, LOOKS).stopped) == dict(whole.stopped)
    for look in LOOKS:
        early = decide(frame[frame["trial"] < look + 1], LOOKS).stopped
        assert early == {key: end for key, end in whole.stopped.items() if end <= look}
    # a run makes no more trials of a cell once it is stopped, and decides the same
    made = [row.trial < whole.stopped.get((row.problem, row.optimizer), 20) for row in frame.itertuples()]
    again = decide(frame[made], LOOKS)
    assert again.stopped == whole.stopped
    pd.testing.assert_frame_equal(again.pairs, whole.pairs)


def test_a_look_counts_once_all_its_trials_are_there(frame_of):
    frame = frame_of(
        {("p", "a"): cell(0, 12, 1), ("p", "b"): cell(5, 12, 2), ("q", "a"): cell(0, 3), ("q", "b"): cell(0, 3)}
    )
    assert decide(frame, LOOKS).stopped == {("p", "a"): 8, ("p", "b"): 8}
    gap = frame[~((frame["problem"] == "p") & (frame["optimizer"] == "b") & (frame["trial"] == 5))]
    found = decide(gap, LOOKS)
    assert found.stopped == {}
    assert found.reached == {"p": 0, "q": 0}
    assert (found.pairs["p"] == 1).all()


def test_failed_trials_count_as_infinite_and_all_tied_cells_are_never_decided(frame_of):
    frame = frame_of(
        {("p", "a"): cell(0, 12), ("p", "b"): [None] * 12, ("q", "a"): [None] * 12, ("q", "b"): [None] * 12}
    )
    assert decide(frame, (11, 12)).stopped == {("p", "a"): 11, ("p", "b"): 11}


def test_nothing_is_decided_without_looks(frame_of):
    found = decide(frame_of({("p", "a"): [1.0] * 9, ("p", "b"): [2.0] * 9}), ())
    assert (found.stopped, found.reached, len(found.pairs)) == ({}, {}, 0)


def test_looks_that_are_blind():
    # complete separation of 10 trials has p = 2 / C(20, 10) = 1.1e-5; of 20 it has 1.5e-11
    assert blind_looks((10, 20, 30, 60)) == [10]
    assert blind_looks((10, 20, 30)) == []
    assert levels((10, 20, 30, 60), 0.05)[0] < 2 / 184_756 < levels((10, 20, 30), 0.05)[0]


def rejected(looks, values):
    """Return (studies, pairs), whether looks, and naive looks at alpha, find a difference; values: (studies, k, n)."""
    one, other = np.triu_indices(values.shape[1], 1)
    p, naive = np.ones((len(values), len(one))), np.ones((len(values), len(one)))
    for place, look in enumerate(looks):
        for pair, (i, j) in enumerate(zip(one, other, strict=True)):
            now = ks_tests(values[:, i, :look], values[:, j, :look])["p"]
            naive[:, pair] = np.minimum(naive[:, pair], now)
            p[:, pair] = np.minimum(p[:, pair], repeated_p(now, looks, place))
    return (np.array(list(map(holm, each))) <= 0.05 for each in (p, naive))


def test_the_simulated_rule_is_that_of_decide(frame_of):
    values = np.random.default_rng(9).normal([[[0.0], [0.5], [1.5]]], 1, (12, 3, 20))
    frame = frame_of({(f"p{s}", f"o{i}"): own for s, study in enumerate(values) for i, own in enumerate(study)})
    kept, _ = rejected(LOOKS, values)
    found = decide(frame, LOOKS)
    significant = at_looks(found.pairs, found)["significant"].to_numpy().reshape(12, 3)
    assert 0 < kept.sum() < kept.size
    assert (significant == kept).all()


@pytest.mark.parametrize(("looks", "optimizers", "studies"), [((10, 20, 30), 2, 6_000), ((10, 15, 20, 25), 3, 2_000)])
def test_equal_optimizers_differ_in_five_percent_of_studies_at_most_and_more_often_at_naive_looks(
    looks, optimizers, studies
):
    values = np.random.default_rng(1).random((studies, optimizers, looks[-1]))
    kept, naive = (each.any(axis=1).mean() for each in rejected(looks, values))
    chance = 2.6 * np.sqrt(0.05 * 0.95 / studies)  # one study in two hundred strays further from exactly 5 %
    assert kept <= 0.05 + chance
    assert naive > 1.4 * kept
    assert naive > 0.05 or optimizers > 2
