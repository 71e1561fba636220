"""Other analyses on the page: optimizers a, b and c find about 5, 6 and 7 on p and q."""

from bench import Results
from bench.topics.findings import Findings
from bench.topics.ranks.multiverse import sections


def test_it_counts_the_analyses_that_agree_and_claims_nothing(make, tmp_path):
    (section,) = sections(Findings(Results(make(tmp_path / "s"))))
    (table,) = section.items
    assert section.folded
    assert table.frame.loc["median"].tolist() == ["a"] * 3
    assert table.frame.loc["targets: quantiles"].tolist() == [
        "–",
        "a",
        "a",
    ]  # none is reached within a tenth of the budget
    assert table.bold.to_numpy().sum() == 17
    assert section.text[0].startswith(
        "Of 17 analyses that could have been chosen, a alone is first in 17, and before b in 17"
    )
    assert "no claim of the page rests on it" in section.text[0]


def test_a_subject_that_is_not_first_is_counted_all_the_same(make, tmp_path):
    (section,) = sections(Findings(Results(make(tmp_path / "s")), asked_subject="b"))
    assert section.text[0].startswith(
        "Of 17 analyses that could have been chosen, b alone is first in 0, and before a in 0"
    )
    assert "c in 17" in section.text[0]


def test_without_a_trace_there_is_none(make, tmp_path):
    lost = [(problem, optimizer) for problem in "pq" for optimizer in "abc"]
    assert sections(Findings(Results(make(tmp_path / "s", trials=2, fail=lost)))) == []
