"""The card on what may limit the answer."""

import pandas as pd

from bench import Results
from bench.analysis.comparison import shared_by
from bench.topics.findings import Findings
from bench.topics.trust.section import section


def said(findings):
    """Return the lines of the card by label, the texts of one label joined."""
    lines = {}
    for line in section(findings).lines:
        lines[line.label] = f"{lines.get(line.label, '')} {line.text}".strip()
    return lines


def test_a_usual_study_has_one_card(make, tmp_path):
    made = section(Findings(Results(make(tmp_path / "s"))))
    assert len(made.cards) == 1
    lines = said(Findings(Results(tmp_path / "s")))
    assert lines["which problems"] == "Only these 2 problems are meant; nothing is claimed of others."
    assert lines["other measures"] == "The lowest median and mean name the same first optimizer on 2 problems."
    assert lines["enough runs"].startswith("The smallest A12 that it shows with a power of 80%:")
    assert [file.path for file in made.files] == ["tables/integrity.csv"]


def test_runs_that_share_seeds_across_problems_are_found():
    rows = [("p", "a", 1), ("q", "a", 1), ("p", "b", 2), ("q", "b", 3), ("p", "c", None), ("q", "c", None)]
    assert shared_by(pd.DataFrame(rows, columns=["problem", "optimizer", "seed"])) == ["a"]
