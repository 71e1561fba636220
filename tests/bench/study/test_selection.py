"""Which optimizers and problems of a study patterns and dimensions select."""

import pytest

from bench import BenchError, Study
from bench.study.selection import selected

PROBLEMS = ["bbob-f01-d2-i1", "bbob-f01-d2-i2", "bbob-f08-d5-i1", "mine"]
DIMENSIONS = dict(zip(PROBLEMS, (2, 2, 5, 5), strict=True)).__getitem__


def study(**changes):
    optimizers = [{"name": "gwo", "label": "gwo[agents=5]"}, {"name": "gwo"}, {"name": "cma-es"}]
    return Study.from_dict({"name": "whole", "problems": PROBLEMS, "optimizers": optimizers} | changes)


def labels(optimizers=None, problems=None, dimensions=None, **changes):
    part = selected(study(**changes), optimizers, problems, dimensions, DIMENSIONS)
    return [[entry.label for entry in entries] for entries in (part.optimizers, part.problems)]


@pytest.mark.parametrize(
    ("patterns", "kept"),
    [
        ("gwo", ["gwo"]), ("gwo*", ["gwo[agents=5]", "gwo"]), (["cma*", "gwo"], ["gwo", "cma-es"]),
        ("gwo[agents=5]", ["gwo[agents=5]"]),
    ],
)  # fmt: skip
def test_a_label_stands_for_itself_and_a_pattern_for_all_that_match_in_the_order_of_the_study(patterns, kept):
    assert labels(patterns)[0] == kept


@pytest.mark.parametrize(
    ("chosen", "message"),
    [
        (("gwoo", None, None), "no optimizer of the study matches 'gwoo'; did you mean 'gwo'"),
        ((None, ["mine", "bbob-f09*"], None), r"no problem of the study matches 'bbob-f09\*'"),
        ((None, None, [5, 3]), "no problem of study 'whole' has dimension 3; known: 2, 5"),
        ((None, "mine", 2), "nothing of study 'whole' is selected"),
        (([], None, None), "nothing of study 'whole' is selected"),
    ],
)
def test_what_selects_nothing_is_one_sentence(chosen, message):
    with pytest.raises(BenchError, match=message) as raised:
        labels(*chosen)
    assert "\n" not in str(raised.value)
