"""Performance profiles on the page: optimizers a, b and c find about 5, 6 and 7 on p and q."""

import pytest

from bench import Results
from bench.topics.anytime.profiles import sections
from bench.topics.findings import Findings


def test_the_first_is_the_fastest_on_every_problem_and_the_caveat_is_there(make, tmp_path):
    (profiles,) = sections(Findings(Results(make(tmp_path / "s"))))
    (figure,) = profiles.items
    assert profiles.folded
    assert figure.shown.loc["tau = 0.1"].tolist() == [1.0, 0.0, 0.0]
    assert len(figure.figure.axes) == 3
    assert "the share of 2 problems" in figure.caption
    assert "who is most often the fastest" in profiles.text[0]


@pytest.mark.parametrize("alone", [{"problems": ("p",)}, {"optimizers": ("a",)}])
def test_one_problem_or_one_optimizer_has_no_profile(make, tmp_path, alone):
    assert sections(Findings(Results(make(tmp_path / "s", **alone)))) == []
