"""The integrity section: what a check noted is warned of."""

import re

from bench import Results
from bench.storage.folder import Folder
from bench.topics.findings import Findings
from bench.topics.integrity import section as integrity
from bench.topics.integrity.checks import checks
from bench.topics.methods.methods import methods
from bench.topics.verdict import section as verdict


def test_the_checks_in_trouble_are_named(make, tmp_path):
    sound = integrity.section(Findings(Results(make(tmp_path / "sound", trials=4)))).text[0]
    failed = integrity.section(Findings(Results(make(tmp_path / "failed", trials=4, fail=[("p", "a", 0)])))).text[0]
    assert "failures" not in sound
    assert re.search(r"[1-9] warnings? or errors? \([^)]*failures", failed)


def test_the_biases_that_a_check_noted_are_warned_of(make, tmp_path):
    def noted(check, passed, figure):
        return {"check": check, "passed": passed, "figure": figure}

    folder = make(tmp_path / "s")
    biased = [
        noted("centre bias", False, 4e5),
        noted("structural bias", False, 5e-10),
        noted("starts and seeds", True, None),
    ]
    sound = [
        noted("centre bias", True, 0.9),
        noted("structural bias", True, 0.4),
        noted("boundary clamping", True, 0.0),
    ]
    Folder(folder).note("checks.json", {"a": biased, "b": sound})
    findings = Findings(Results(folder))
    assert integrity.section(findings).warnings == ()  # they are said once, by the verdict
    warnings = verdict.section(findings).warnings
    assert [warning.partition(":")[0] for warning in warnings[:2]] == ["Centre bias", "Structural bias"]
    assert "not uniform in the box: a p = 5e-10." in warnings[1]
    verdicts = findings.of(checks).set_index("check")["verdict"]
    assert set(verdicts[["boundary clamping", "starts and seeds"]]) == {"pass"}
    paragraph = methods(findings).text[0]  # what was tested; what was found is a result
    assert "We tested a and b for a bias towards the centre of the search space, by errors" in paragraph
    assert "We tested a and b for structural bias" in paragraph
    assert "found" not in paragraph.partition("We tested")[2]
    table = next(item for item in integrity.section(findings).items if item.name == "integrity")
    assert "a 4e+05 times" in table.frame.at["centre bias", "finding"]
