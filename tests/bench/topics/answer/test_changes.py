"""What was changed after the first results, by the history of a folder."""

import pytest

from bench import Results
from bench.storage.folder import Folder
from bench.topics.answer.changes import changes
from bench.topics.answer.section import lines
from bench.topics.findings import Findings
from bench.topics.trust.section import section

FIRST = {"when": "2026-01-01", "seed": 0, "trials": 8, "budget": 100, "subject": "", "problems": ["p", "q"],
         "optimizers": ["a", "b", "c"]}  # fmt: skip


def found(folder, *records, subject=None):
    with Folder(folder).store.writer() as writer:
        for record in records:
            writer.record("history", record)
    return Findings(Results(folder), asked_subject=subject)


@pytest.mark.parametrize(
    ("first", "subject", "made"),
    [
        ({}, None, ()),
        ({"problems": ["p"]}, None, ("1 problem added",)),
        ({"problems": ["p", "q", "r"]}, None, ("1 problem removed",)),
        ({"optimizers": ["a", "b", "c", "d", "e"]}, None, ("2 optimizers removed",)),
        ({"optimizers": ["a"]}, None, ("2 optimizers added",)),
        ({"trials": 4}, None, ("trials extended from 4 to 8",)),
        ({"budget": 50}, None, ("another budget",)),
        ({}, "b", ("subject named late",)),
        ({"subject": "b"}, "b", ("subject dropped",)),
    ],
)
def test_each_change_is_said_in_place_of_the_5_percent(make, tmp_path, first, subject, made):
    last = FIRST | {"when": "2026-01-02"}
    if made == ("subject dropped",):
        subject = None
    findings = found(make(tmp_path / "s"), FIRST | first, last, subject=subject)
    assert changes(findings) == (True, made)
    (sure,) = (line.text for line in lines(findings) if line.label == "how sure")
    assert ("at most 5%" in sure) == (not made)
    assert ("run again with another seed: bench run … --seed 1" in sure) == bool(made)
    (said,) = (line.text for line in section(findings).lines if line.label == "changed after the results")
    assert all(change in said for change in made)


def test_a_folder_without_a_record_says_that_nothing_is_known(make, tmp_path):
    findings = found(make(tmp_path / "s"))
    assert changes(findings) == (False, ())
    assert "changes after the results are not known" in str(lines(findings))
    assert "Not known: the folder has no record" in str(section(findings).lines)
