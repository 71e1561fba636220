"""The table of running times on suites: its target is the one that the rest of the page names."""

import pytest

from bench import Results, Study, load_problem
from bench.topics.course.times import ratios
from bench.topics.findings import Findings
from tests.bench.reports import ended, store


def test_a_target_by_running_length_has_the_number_of_evaluations_that_its_set_names(tmp_path):
    pytest.importorskip("cocoex")
    suite = {"suite": "bbob", "functions": [1], "dimensions": [2], "instances": "1-2"}
    optimizers = [{"name": "random-search"}, {"name": "gwo"}]
    study = {"name": "made", "trials": 2, "budget": 100, "problems": [suite], "optimizers": optimizers}
    made = Study.from_dict(study | {"targets": "runlength"})
    optima = {entry.label: load_problem(entry.name).optimum for entry in made.problems}
    store(tmp_path / "s", made, lambda trial: ended(optima[trial.problem] + 1e-9))
    findings = Findings(Results(tmp_path / "s"))
    chosen, table = findings.anytime.target_set, ratios(findings)
    assert chosen.at(chosen.level) == "the target for 10 d evaluations"
    assert "the target for 10 d evaluations" in table.caption
    assert "to the target for 10 d evaluations." in table.note
