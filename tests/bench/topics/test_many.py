"""What a page shows of many optimizers: the first ten and the subject; files have all."""

import pytest

from bench import Results
from bench.topics.findings import FEW, Findings


@pytest.fixture(scope="module")
def wide(make, tmp_path_factory):
    labels = tuple(f"o{number:02d}" for number in range(FEW + 2, 0, -1))  # the last one is the worst
    return Findings(Results(make(tmp_path_factory.mktemp("wide") / "s", ("p", "q", "r"), labels, trials=5)))


def test_of_more_the_first_ten_and_the_subject_are_shown(wide):
    assert wide.display.shown == wide.final.ranked[:10]
    last = wide.final.ranked[-1]
    again = Findings(wide.results, asked_subject=last)
    assert again.display.shown == [*wide.final.ranked[:10], last]
    own = [label for label, pen in wide.display.pens.items() if not pen.background]
    assert sorted(own) == sorted(wide.display.shown)
    assert len({wide.display.pens[label].color for label in own}) == 10


def test_of_a_crowd_the_tests_of_the_first_and_the_subject_are_kept(wide, monkeypatch):
    everyone = wide.final.pairs
    monkeypatch.setattr("bench.topics.findings.final.CROWD", 12)
    pairs = Findings(wide.results, asked_subject=wide.final.ranked[-1]).final.pairs
    kept = {*wide.final.ranked[:10], wide.final.ranked[-1]}
    clearest = pairs.groupby("problem", observed=True)["p_holm"].idxmin()
    others = pairs[~pairs["first"].isin(kept) & ~pairs["second"].isin(kept)]
    assert set(others.index) <= set(clearest)
    assert len(pairs) - len(others) == 3 * (91 - 3)
    whole = everyone.merge(pairs, on=["problem", "first", "second"], suffixes=("", "_kept"))
    assert len(whole) == len(pairs)
    assert (whole["p_holm"] == whole["p_holm_kept"]).all()
