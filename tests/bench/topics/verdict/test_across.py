"""What may not be claimed of pairs: optimizers a, b and c find about 5, 6 and 7, or c almost as low values as a."""

import pytest

from bench import Results
from bench.topics.findings import Findings
from bench.topics.verdict.across import across


def said(folder):
    return across(Findings(Results(folder)))


@pytest.mark.parametrize(
    ("more", "end"),
    [({"trials": 12}, "over these problems, and on each of them."),
     ({"trials": 6}, "over these problems; on single problems none is tested."),
     ({"trials": 12, "changes": {"c": {"fun": 5.1}}}, "over these problems, but only 2 of 3 on each of them.")],
)  # fmt: skip
def test_whether_pairs_differ_on_each_problem_is_counted(make, tmp_path, more, end):
    assert said(make(tmp_path / "s", **more)) == f"Every pair of optimizers differs significantly {end}"


def test_the_rivals_that_differ_from_a_subject_on_each_problem_are_named(make, tmp_path):
    own = {"subject": "a", "record": {"subject": "a"}}
    folder = make(tmp_path / "s", trials=12, changes={"c": {"fun": 5.1}}, **own)
    assert said(folder) == "Every rival differs from a significantly over these problems, but only b on each of them."
