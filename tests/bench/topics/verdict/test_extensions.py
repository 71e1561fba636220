"""Trials that were added to complete ones are said on the first screen and among the checks."""

from bench import Results
from bench.topics.findings import Findings
from bench.topics.integrity import section as integrity
from bench.topics.verdict import section as verdict


def said(folder, records):
    """Return the findings, and the sentences on optional stopping in the card of what may not be claimed."""
    results = Results(folder)
    results.environments[:] = records
    findings = Findings(results)
    limits = verdict.section(findings).cards[2].text
    return findings, [text for text in limits if text.startswith("Optional stopping: ")]


def test_trials_that_were_added_to_complete_ones_are_said_once_in_each_part(make, tmp_path):
    folder = make(tmp_path / "s", trials=12)
    record = {"trials": 12, "extends": 8, "packages": {}}
    known, (sentence,) = said(folder, [{"trials": 8, "extends": None}, record, record])
    assert known.trials.extensions == [(8, 12)]
    assert "8 trials of each cell were complete, and could be looked at, when 12 were asked for." in sentence
    assert sum(each.startswith("Optional stopping: Trials were added") for each in integrity.warnings(known)) == 1
    assert said(folder, [{"trials": 12, "extends": 3}, {"started": "of an older version"}])[1] == []
