"""Declared looks in a study's file: what is accepted, what is refused in one sentence, and what they belong to."""

import tomllib

import pytest

from bench import BenchError, Study
from bench.study import Entry
from bench.study.looks import Looks


def study(looks=None, optimizers=("gwo", "da"), problems=("sphere-2",), **more):
    given = {} if looks is None else {"looks": looks}
    return Study.from_dict(
        {"name": "s", "problems": [{"names": list(problems)}], "optimizers": [{"names": list(optimizers)}]}
        | given
        | more
    )


def test_the_last_look_is_the_number_of_trials_and_the_file_reads_back():
    made = study({"trials": [10, 20, 40]})
    assert (made.trials, made.looks) == (40, (10, 20, 40))
    assert Study.from_dict(tomllib.loads(made.to_toml())) == made
    assert study({"trials": [10, 20, 40]}, trials=40) == made
    assert made.override(trials=40, seed=3).looks == made.looks
    assert study().looks == ()
    assert "looks" not in study().to_toml()


def test_looks_belong_to_the_identity_only_where_there_are_any():
    assert len({study(each, trials=40).identity() for each in (None, [10, 40], [20, 40], [10, 20, 40])}) == 4
    assert study(trials=3).identity() == study(trials=40).identity()


@pytest.mark.parametrize(
    ("looks", "reason"),
    [
        ([10], "must be two or more"),
        ([], "must be two or more"),
        ({"trials": [20, 10]}, "must increase"),
        ({"trials": [10, 10]}, "must increase"),
        ([3, 10], "must begin with 6 trials or more, not 3"),
        ([-4, 10], "must begin with 6"),
        ([10, 10**30], "must be at most 1,000,000 trials"),
        ([10, 20.5], "list of numbers of trials"),
        ([True, 20], "list of numbers of trials"),
        ("10, 20", "list of numbers of trials"),
        (7, "list of numbers of trials"),
        ({}, "list of numbers of trials"),
        ({"trial": [10, 20]}, "unknown key 'trial'; did you mean 'trials'?"),
    ],
)
def test_what_are_no_looks(looks, reason):
    with pytest.raises(BenchError, match=r"^study given: 'looks'") as raised:
        study(looks)
    assert reason in str(raised.value)
    assert "\n" not in str(raised.value)


def test_looks_beyond_or_short_of_the_trials_are_refused():
    for trials in (30, 50):
        with pytest.raises(
            BenchError, match=f"'trials' is {trials}, but the last of the declared looks is at 40 trials"
        ):
            study([10, 40], trials=trials)
        with pytest.raises(BenchError, match=f"^'trials' is {trials}"):
            study([10, 40]).override(trials=trials)


def test_one_optimizer_and_instances_of_one_function_are_refused():
    with pytest.raises(BenchError, match="'looks' needs two optimizers or more"):
        study([10, 20], optimizers=["gwo"])
    with pytest.raises(BenchError, match="pool the instances of 'bbob-f01-d2'"):
        study([10, 20], problems=["bbob-f01-d2-i1", "bbob-f02-d2-i1", "bbob-f01-d2-i2"])
    assert study([10, 20], problems=["bbob-f01-d2-i1", "bbob-f02-d2-i1"]).looks == (10, 20)
    with pytest.raises(BenchError, match="'looks' compares problem by problem"):
        study([10, 20], problems=["bbob-f01-d2-i1"]).beside(problems=["bbob-f01-d2-i2"])


def test_looks_are_whole_numbers_of_python():
    assert Looks.read((6, 9), "looks") == (6, 9)


def test_in_python_the_last_look_is_the_number_of_trials_too():
    entries = (Entry("p", "p"),), (Entry("a", "a"), Entry("b", "b"))
    assert Study("s", *entries, looks=[6, 9]).trials == 9
    assert Study("s", *entries, looks=()).trials == Study("s", *entries).trials == 30
