"""What declared looks decide: by hand on separated cells, from the trials before a look alone, and at which level."""

import numpy as np
import pandas as pd
import pytest

from bench.analysis.direction import effects, least_p, p_values
from bench.analysis.looks import at_looks, blind_looks, decide
from bench.analysis.pairwise import holm, pairwise_tests
from bench.analysis.sequential import levels, repeated_p

LOOKS = (8, 12, 20)


def cell(low, n, seed=0):
    return (low + np.random.default_rng(seed).random(n)).tolist()


def test_separated_cells_stop_at_the_first_look_that_can_see_it(frame_of):
    # a and b never differ; c is separated from both, which 12 trials can show at the level of that look and 8 cannot
    frame = frame_of({("p", "a"): cell(0, 20, 1), ("p", "b"): cell(0, 20, 2), ("p", "c"): cell(5, 20, 3)})
    found = decide(frame, LOOKS)
    first, second = (3 * repeated_p(least_p(n), LOOKS, i) for i, n in enumerate((8, 12)))
    assert first > 0.05 > second
    assert found.stopped == {("p", "c"): 12}
    assert found.reached == {"p": 20}
    pairs = found.pairs.set_index(["first", "second"])
    assert pairs.loc[("a", "c"), "look"] == pairs.loc[("b", "c"), "look"] == 12
    assert pairs.loc[("a", "c"), "p"] == pytest.approx(second / 3)
    tested = at_looks(pairwise_tests(frame), found)
    assert tested["significant"].tolist() == [False, True, True]
    np.testing.assert_allclose(tested["p_holm"], holm(tested["p"].to_numpy()))
    assert tested["stopped"].tolist() == [False, True, True]
    before = pairwise_tests(frame)
    assert tested["a12"].tolist() == before["a12"].tolist()
    for end in ("a12_low", "a12_high", "joint_low", "joint_high"):
        assert tested[end].isna().tolist() == [False, True, True]
        assert tested[end].iloc[0] == before[end].iloc[0]


def test_the_level_is_divided_between_the_problems(frame_of):
    apart = {("p0", "a"): cell(0, 8, 1), ("p0", "b"): cell(5, 8, 2)}  # p = 1/128, between 0.05 / 7 and 0.05 / 6
    for problems, stopped in ((1, True), (6, True), (7, False)):
        others = {(f"p{i}", name): cell(0, 8, i) for i in range(1, problems) for name in "ab"}
        found = decide(frame_of(apart | others), (8,))
        assert set(found.stopped) == ({("p0", "a"), ("p0", "b")} if stopped else set())


def test_decisions_follow_from_the_trials_before_a_look_alone(frame_of):
    rng = np.random.default_rng(4)
    values = {(f"p{i}", f"o{j}"): rng.normal(6.0 * (j // 2) + 1.0 * i * j, 1, 20) for i in range(4) for j in range(4)}
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
    assert decide(frame, LOOKS).stopped == {("p", "a"): 12, ("p", "b"): 12}
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
    looks = (10, 20, 30)  # complete separation of 10 trials has p = 1/512
    assert levels(looks, 0.05)[0] < least_p(10)
    assert levels(looks, 0.05)[1] > least_p(20)
    assert blind_looks(looks) == [10]
    assert blind_looks((15, 30)) == []
    assert blind_looks((15, 30), tests=50) == [15]
    assert blind_looks(looks, tests=100_000) == [10, 20]
    assert blind_looks((3, 5), alpha=0.05) == [3, 5]


def rejected(looks, values):
    """Return (studies, pairs), whether looks, and naive looks at alpha, find a difference; values: (studies, k, n)."""
    one, other = np.triu_indices(values.shape[1], 1)
    p, naive = np.ones((len(values), len(one))), np.ones((len(values), len(one)))
    for place, look in enumerate(looks):
        for pair, (i, j) in enumerate(zip(one, other, strict=True)):
            now = p_values(effects(values[:, i, :look], values[:, j, :look]))
            naive[:, pair] = np.minimum(naive[:, pair], now)
            p[:, pair] = np.minimum(p[:, pair], repeated_p(now, looks, place))
    return (np.array(list(map(holm, each))) <= 0.05 for each in (p, naive))


def test_the_simulated_rule_is_that_of_decide(frame_of):
    values = np.random.default_rng(9).normal([[[0.0], [0.5], [1.5]]], 1, (12, 3, 20))
    frame = frame_of({(f"p{s}", f"o{i}"): own for s, study in enumerate(values) for i, own in enumerate(study)})
    kept, _ = rejected(LOOKS, values)
    found = decide(frame, LOOKS, alpha=12 * 0.05)  # 0.05 for each of 12 problems
    p = found.pairs["p"].to_numpy().reshape(12, 3)
    significant = np.array(list(map(holm, p))) <= 0.05
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
