"""The trials of a study in words: instances counted where they are pooled, and problem by problem where they differ."""

import pandas as pd

from bench.topics.findings.replication import each_problem, replications


def covered(stored):
    """Return the coverage of cells (problem, optimizer) that hold so many trials."""
    return pd.DataFrame(
        [(*cell, number) for cell, number in stored.items()], columns=["problem", "optimizer", "stored"]
    )


def words(stored, members, planned=3):
    return each_problem(replications(covered(stored), members, {"a": planned, "b": planned}))


def test_nine_trials_of_three_instances_say_so():
    assert words({("f", "a"): 9, ("f", "b"): 9}, {"f": ["f1", "f2", "f3"]}) == (
        "9 trials (3 on each of 3 instances) each"
    )


def test_problems_with_and_without_instances_have_their_own_numbers():
    stored = {("f", "a"): 15, ("g", "a"): 15, ("p", "a"): 5, ("f", "b"): 15, ("g", "b"): 15, ("p", "b"): 5}
    members = {"f": ["f1", "f2", "f3"], "g": ["g1", "g2", "g3"], "p": ["p"]}
    assert words(stored, members, planned=5) == (
        "15 trials (5 on each of 3 instances) on each of 2 problems and 5 trials on each of 1 problem"
    )
