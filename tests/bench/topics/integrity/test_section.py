"""The integrity section: what a check noted is warned of once; methods state what was tested, not what was found."""

from bench import Results
from bench.storage.folder import Folder
from bench.topics.findings import Findings
from bench.topics.integrity import section as integrity
from bench.topics.integrity.checks import checks
from bench.topics.methods.methods import methods
from bench.topics.verdict import section as verdict


def test_the_biases_that_a_check_noted_are_warned_of_by_the_verdict_alone(make, tmp_path):
    folder = make(tmp_path / "s")
    found = {"centre bias": 4e5, "structural bias": 5e-10, "starts and seeds": None}
    noted = [{"check": each, "passed": each.startswith("starts"), "figure": figure} for each, figure in found.items()]
    Folder(folder).note("checks.json", {"a": noted})
    findings = Findings(Results(folder))
    assert integrity.section(findings).warnings == ()
    warnings = verdict.section(findings).warnings
    assert [warning.partition(":")[0] for warning in warnings[:2]] == ["Centre bias", "Structural bias"]
    assert findings.of(checks).set_index("check").at["starts and seeds", "verdict"] == "pass"
    assert "found" not in methods(findings).text[0].partition("We tested")[2]
