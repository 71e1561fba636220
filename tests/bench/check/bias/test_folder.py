"""The verdicts on a study's optimizers, kept in its folder."""

import json
from dataclasses import asdict
from functools import partial

import pytest

from bench import Results, Study, run
from bench.check.bias import diagnose
from bench.check.bias.folder import diagnose_folder
from bench.check.bias.functions import FUNCTIONS
from bench.check.verdict import Verdict
from bench.storage.folder import Folder


@pytest.fixture(autouse=True)
def few_runs(monkeypatch):
    monkeypatch.setattr("bench.check.bias.runs.FUNCTIONS", {"sphere": FUNCTIONS["sphere"]})
    monkeypatch.setattr("bench.check.bias.folder.diagnose", partial(diagnose, dimension=2, runs=1, noise_runs=3))


def test_a_folder_keeps_the_verdicts_on_its_optimizers(tmp_path):
    entries = [{"name": "scatter", "agents": 7}, {"name": "early"}]
    study = {"name": "s", "trials": 1, "budget": 40, "problems": [{"name": "sphere-3"}], "optimizers": entries}
    run(Study.from_dict(study), tmp_path / "out", n_jobs=1)
    assert Results(tmp_path / "out").checks == {}
    found, failed = diagnose_folder(Folder(tmp_path / "out"), n_jobs=1)
    assert failed == {}
    assert list(found) == ["scatter", "early"]
    assert found["scatter"] == diagnose(
        Study.from_dict(study).optimizer("scatter"), n_jobs=1, dimension=2, runs=1, noise_runs=3
    )
    assert Results(tmp_path / "out").checks == {
        label: [asdict(each) for each in those] for label, those in found.items()
    }


def test_notes_of_older_versions_are_read_and_what_is_no_verdict_is_passed_over(tmp_path, small_study):
    run(small_study.override(trials=1), tmp_path / "out", n_jobs=1)
    old = {"check": "centre bias", "passed": False, "figure": 50.0, "finding": "worse off the centre"}
    new = Verdict("starts and seeds", "bias", True, "every run starts at the same point").as_dict()
    notes = {
        "scatter": [old, new, old | {"check": 3}, old | {"passed": "no"}, old | {"figure": "50"}, {}],
        "early": 5,
        "hill-climber": [old, 5],
        "stranger": [old],
    }
    (tmp_path / "out" / "checks.json").write_text(json.dumps(notes))
    assert Results(tmp_path / "out").checks == {"scatter": [old | {"kind": "bias", "mend": ""}, new]}


def test_an_optimizer_that_fails_costs_the_others_nothing(tmp_path):
    entries = [{"name": "faulty"}, {"name": "scatter"}]
    study = {"name": "s", "trials": 1, "budget": 40, "problems": [{"name": "sphere-3"}], "optimizers": entries}
    run(Study.from_dict(study), tmp_path / "out", n_jobs=1)  # 'faulty' raises in two dimensions
    found, failed = diagnose_folder(Folder(tmp_path / "out"), n_jobs=1)
    assert list(found) == list(Results(tmp_path / "out").checks) == ["scatter"]
    assert failed == {"faulty": "the optimizer failed on sphere: RuntimeError: cannot do planes"}
