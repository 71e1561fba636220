"""U-scores by hand, by counting every pair, and by scipy's Mann-Whitney U."""

import numpy as np
import pandas as pd
import pytest

from bench import Trace, analysis

OPTIMUM = 100.0
FAILED = "failed"


def study(outcomes, optimum=OPTIMUM):
    """Return frame and traces of trials by optimizer: (evaluations to the target or None, final error) or a failure."""
    rows, traces = [], {}
    for optimizer, trials in outcomes.items():
        for number, trial in enumerate(trials):
            lost = trial == FAILED
            rows.append(("p", optimizer, number, "failed" if lost else "ok", np.nan if lost else optimum + trial[1]))
            if not lost:
                found = trial[0] is not None
                at, values = ([1, trial[0]], [50.0, trial[1]]) if found else ([1], [trial[1]])
                traces["p", optimizer, number] = Trace(np.array(at), optimum + np.array(values))
    return pd.DataFrame(rows, columns=["problem", "optimizer", "trial", "status", "fun"]), traces


def scores(outcomes, **options):
    table = analysis.u_scores(*study(outcomes), {"p": OPTIMUM}, **options)
    return table.set_index("optimizer")["u"].to_dict()


def wins(one, other):
    """Return 1 where a trial wins over another one, 1/2 for a tie, else 0; from the rule, pair by pair."""

    def order(trial):
        return (1, 1, 0) if trial == FAILED else (0, 0, trial[0]) if trial[0] else (0, 1, trial[1])

    return 1.0 if order(one) < order(other) else 0.5 if order(one) == order(other) else 0.0


BY_HAND = {"a": [(50, 0.0), (60, 0.0)], "b": [(80, 0.0), (None, 1.0)], "c": [(50, 0.0), (None, 3.0)]}


def test_an_example_by_hand():
    # a's 50: beats b twice and c's 3.0, ties c's 50; a's 60: beats b twice and c's 3.0. b's 80 and 1.0: beat c's 3.0.
    # c's 50: ties a's 50, beats a's 60 and b twice.
    assert scores(BY_HAND) == {"a": 6.5, "b": 2.0, "c": 3.5}
    assert scores(BY_HAND | {"c": [FAILED, FAILED]}) == {"a": 8.0, "b": 4.0, "c": 0.0}


def random_outcomes(rng, optimizers, trials):
    def one():
        kind = rng.random()
        if kind < 0.1:
            return FAILED
        return (int(rng.integers(2, 9)), 0.0) if kind < 0.6 else (None, float(rng.integers(1, 6)))

    return {optimizer: [one() for _ in range(trials)] for optimizer in optimizers}


@pytest.mark.parametrize("seed", range(20))
def test_the_score_is_the_number_of_pairs_won(seed):
    outcomes = random_outcomes(np.random.default_rng(seed), "abcd", 7)
    expected = {
        own: sum(wins(x, y) for other in outcomes if other != own for x in outcomes[own] for y in outcomes[other])
        for own in outcomes
    }
    assert scores(outcomes) == expected
    assert sum(expected.values()) == 6 * 7 * 7


def test_reached_trials_are_counted_at_the_precision():
    outcomes = {"a": [(9, 0.5)], "b": [(None, 0.5)]}
    table = analysis.u_scores(*study(outcomes), {"p": OPTIMUM})
    assert table["reached"].tolist() == [0, 0]
    assert table["u"].tolist() == [0.5, 0.5]
    assert scores(outcomes, precision=1.0) == {"a": 0.0, "b": 1.0}  # b was there at its first evaluation


def test_a_problem_without_optimum_or_with_unequal_trials_has_no_row():
    frame, traces = study(BY_HAND)
    assert analysis.u_scores(frame, traces, {}).empty
    assert analysis.u_scores(frame[:-1], traces, {"p": OPTIMUM}).empty
    assert analysis.u_scores(frame[:0], traces, {"p": OPTIMUM}).empty
    assert list(analysis.u_scores(frame[:0], traces, {})) == ["problem", "optimizer", "trials", "reached", "u", "pairs"]
