"""The card on what may limit the answer."""

import pandas as pd
import pytest

from bench import Results
from bench.analysis.comparison import shared_by
from bench.topics.findings import Findings
from bench.topics.trust.section import crowded, section


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


def test_without_a_trial_there_is_no_section(make, tmp_path):
    none = [(problem, optimizer) for problem in "pq" for optimizer in "abc"]
    assert section(Findings(Results(make(tmp_path / "s", skip=none)))) is None


@pytest.mark.parametrize(
    ("records", "said"),
    [
        ([{"jobs": 2, "cores": 2}, {"jobs": 1, "cores": 2}], False),
        ([{"jobs": 2, "cores": 2}, {"jobs": 3, "cores": 2}], True),
        ([{"jobs": 4, "cores": 2, "host": "one"}, {"jobs": 4, "cores": 2, "host": "two"}], False),
        ([{"jobs": 4, "cores": 2, "host": "one"}, {"jobs": 4, "cores": 2, "host": "one"}], True),
        ([{"jobs": 2}], False),
        ([], False),
    ],
)
def test_the_cores_of_all_machines_of_a_run_count(records, said):
    starts = ["a", "b"] if not any("host" in record for record in records) else ["a", "a"]
    assert crowded([{"started": start} | record for start, record in zip(starts, records, strict=False)]) == said
