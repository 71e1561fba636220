"""The names of a suite's problems."""

import pytest

from bench import BenchError, Grid

NUMBERED = Grid("suite", {"f01": (2, 5), "f03": (5,)}, instances=2)
NAMED = Grid("other", {"ball": (2,), "saw-tooth": (2, 30)})


@pytest.mark.parametrize(
    ("grid", "name", "sentence"),
    [
        (NUMBERED, "suite-f02-d2-i1", "suite has no function 'f02'; it has f01 to f03 without f02"),
        (NUMBERED, "suite-f03-d2-i1", "f03 of suite has no dimension 2; it has 5"),
        (NUMBERED, "suite-f03-d5-i0", "instance of 'suite-f03-d5-i0' must be a whole number from 1 to 200000, not 0"),
        (NUMBERED, "suite-f03-d5", "the problems of suite have names such as 'suite-f01-d2-i1'"),
        (NUMBERED, "suite-f01-d02-i1", "unknown problem 'suite-f01-d02-i1'"),
        (NAMED, "other-ball-d2-i1", "unknown problem 'other-ball-d2-i1'"),
        (NAMED, "other-bell-d2", "other has no function 'bell'; did you mean 'ball'?"),
    ],
)  # fmt: skip
def test_one_sentence_names_what_there_is(grid, name, sentence):
    with pytest.raises(BenchError) as caught:
        grid.member(name)
    assert sentence in str(caught.value)
