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


def test_what_was_planned_is_said_by_problem_where_trials_are_missing():
    members = {"f": ["f1", "f2"], "p": ["p"]}
    stored = {("f", "a"): 6, ("f", "b"): 5, ("p", "a"): 3, ("p", "b"): 3}
    assert words(stored, members) == (
        "3 trials on each of 1 problem and 5 to 6 trials (of 6 planned, 3 on each of 2 instances) on each of 1 problem"
    )


def test_without_a_plan_or_trials_nothing_is_said_of_either():
    assert words({("f", "a"): 9, ("f", "b"): 9}, {"f": ["f1", "f2"]}, planned=0) == "9 trials (on 2 instances) each"
    assert words({("p", "a"): 4, ("p", "b"): 5}, {"p": ["p"]}, planned=0) == "4 to 5 trials each"
    different = replications(covered({("p", "a"): 4, ("p", "b"): 5}), {"p": ["p"]}, {"a": 4, "b": 5})
    assert each_problem(different) == "4 to 5 trials each"
    assert words({("p", "a"): 0}, {"p": ["p"]}) == "no trial yet"


def test_empty_cells_do_not_count():
    assert words({("p", "a"): 3, ("p", "b"): 0}, {"p": ["p"]}) == "3 trials each"
