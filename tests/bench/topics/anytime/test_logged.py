"""What an optimizer logs: from the trial to the results, the report and the files of IOHprofiler."""

import json

import pytest

from bench import Results, Study, run, solve
from bench.formats.exporting import export
from bench.topics.anytime.logged import section
from bench.topics.findings import Findings

LOGS = """
def logs(objective, rng):
    step = 1.0
    while True:
        objective.log(step=step)
        objective(objective.initial(10))
        step = step / 2

def plain(objective, rng):
    while True:
        objective(objective.initial(10))
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("logged")
    (path / "mine.py").write_text(LOGS)
    optimizers = [{"name": f"{path / 'mine.py'}:{name}"} for name in ("logs", "plain")]
    table = {"name": "s", "trials": 2, "budget": 40, "problems": ["classical-sphere-d2-i1"], "optimizers": optimizers}
    run(Study.from_dict(table), path / "out", n_jobs=1, verify=False)
    return path / "out"


EXPECTED = {0: 1.0, 10: 0.5, 20: 0.25, 30: 0.125, 40: 0.0625}


def test_results_have_it_by_trial_name_and_evaluations(folder):
    logs = Results(folder).logs
    assert {*logs["optimizer"]} == {"logs"}
    for _, rows in logs.groupby("trial"):
        assert dict(zip(rows["evaluations"], rows["value"], strict=True)) == EXPECTED


def test_a_run_from_python_has_it(folder):
    found = solve("classical-sphere-d2-i1", f"{folder.parent / 'mine.py'}:logs", budget=40)
    assert dict(found.log["step"]) == EXPECTED


def test_a_report_draws_it_beside_the_convergence(folder):
    found = section(Findings(Results(folder)))
    (figure,) = found.items
    assert figure.name == "logged-step"
    assert found.text[0].startswith("logs logged step during the search.")


def test_ioh_files_have_it_as_a_column(folder, tmp_path):
    export(Results(folder), "ioh", tmp_path / "ioh")
    (index,) = (tmp_path / "ioh" / "logs").glob("*.json")
    assert json.loads(index.read_text())["attributes"] == ["evaluations", "raw_y", "step"]
    (log,) = (tmp_path / "ioh" / "logs").rglob("*.dat")
    head, first, *_ = log.read_text().splitlines()
    assert head == "evaluations raw_y step"
    assert first.split()[2] == "1.0"
    (other,) = (tmp_path / "ioh" / "plain").rglob("*.dat")
    assert other.read_text().startswith("evaluations raw_y\n")
