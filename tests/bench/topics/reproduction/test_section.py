"""The script beside a report makes the numbers of its tables from the trials, and says what it does not make."""

import ast
import runpy
import sys

import numpy as np
import pandas as pd
import pytest

from bench import Results, Study, run
from bench.topics.findings import Findings
from bench.topics.reproduction import section
from bench.topics.write import write_report

POOLED = {"suite": "classical", "functions": ["sphere", "rastrigin"], "dimensions": [2], "instances": "1-2"}
OPTIMIZERS = [{"name": "gwo", "agents": 10}, {"name": "random-search"}, {"name": "cma-es"}]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with a report: pooled instances beside a problem without, some trials failed, one cell empty."""
    study = Study.from_dict(
        {
            "name": "reproduced",
            "trials": 4,
            "budget": 120,
            "problems": [POOLED, {"name": "engineering-spring"}, {"name": "classical-step-d2-i1"}],
            "optimizers": OPTIMIZERS,
        }
    )
    made = run(study, tmp_path_factory.mktemp("run") / "reproduced", jobs=1).folder
    write_report(made, jobs=1)
    return made


@pytest.fixture
def reproduce(monkeypatch, capsys):
    """Return a function that runs the script of a folder and returns its exit code and what it printed."""

    def call(folder, *arguments):
        monkeypatch.setattr(sys, "argv", ["reproduce.py", *map(str, arguments)])
        code = runpy.run_path(str(folder / "reproduce.py"))["main"]()
        return code, capsys.readouterr().out

    return call


def test_every_value_that_it_makes_is_that_of_the_report(folder, reproduce):
    code, printed = reproduce(folder)
    assert code == 0
    assert " values made from 72 runs, 0 differ; printed tables not made: " in printed.splitlines()[-1]
    assert "power" in printed.splitlines()[-1]
    assert "environment" not in printed.splitlines()[-1]
    for name in ("cells", "tests", "comparison", "ranking", "pairs-over-problems", "running-times", "success-rates"):
        assert f"{name}.csv: " in printed.partition("not made")[0]


@pytest.mark.slow
def test_with_a_subject_it_tests_the_same_pairs(tmp_path, reproduce):
    problems = [{"name": f"classical-{name}-d2-i1"} for name in ("sphere", "rastrigin")]
    study = {"name": "s", "subject": "gwo", "trials": 12, "budget": 60, "problems": problems, "optimizers": OPTIMIZERS}
    folder = run(Study.from_dict(study), tmp_path / "s", jobs=1).folder
    write_report(folder, jobs=1)
    tests = pd.read_csv(folder / "tables" / "tests.csv")
    assert tests["p_holm"].notna().sum() == 4
    assert "& against gwo &" in (folder / "tables" / "cells-classical-sphere-d2-i1.tex").read_text()
    code, printed = reproduce(folder)
    assert " 0 differ; " in printed.splitlines()[-1]
    for name in ("against-rivals", "competition", "competition-statistics"):
        assert f"{name}.csv: " in printed.partition("not made")[0]
    assert code == 0


def test_it_names_what_it_does_not_make(folder, reproduce):
    left = reproduce(folder)[1].partition("not made")[2]
    assert "(simulated restarts): p10 of running-times.csv" in left
    assert "rank_low of ranking.csv" in left
    assert "environment.csv" in left


def test_a_value_that_was_changed_differs(folder, reproduce):
    path = folder / "tables" / "cells.csv"
    before = path.read_bytes()
    cells = pd.read_csv(path)
    cells.loc[0, "median"] += 1.0
    cells.to_csv(path, index=False)
    try:
        code, printed = reproduce(folder)
    finally:
        path.write_bytes(before)
    assert code == 1
    assert "cells.csv: " in printed
    assert " 1 differ; " in printed.splitlines()[-1]


def test_it_needs_numpy_scipy_and_pandas_alone(folder):
    tree = ast.parse((folder / "reproduce.py").read_text(encoding="utf-8"))
    modules = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    modules |= {str(node.module) for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    named = {module.partition(".")[0] for module in modules}
    assert named - {*sys.stdlib_module_names} == {"numpy", "scipy", "pandas"}


def test_traces_that_are_too_many_are_not_written(folder, monkeypatch):
    monkeypatch.setattr(section, "MOST_IMPROVEMENTS", 10)
    files = {file.path: file for file in section.beside(Findings(Results(folder)))}
    assert set(files) == {"reproduce.py", "reproduce.json"}


def test_without_traces_it_makes_the_rest(folder, reproduce, tmp_path):
    code, printed = reproduce(folder, "--traces", tmp_path / "none.csv")
    assert code == 0
    assert "not made (needs the traces): " in printed
    assert "cells.csv: " in printed


STUDIES = {
    "failed": {"problems": [{"names": ["sphere-2", "sphere-3"]}], "optimizers": ["faulty", "scatter", "early"]},
    "alone": {"problems": [POOLED], "optimizers": ["gwo"]},
    "once": {"problems": [{"names": ["sphere-2", "sphere-3"]}], "optimizers": ["scatter", "early"], "trials": 1},
    "quantiles": {"problems": [POOLED], "optimizers": ["gwo", "random-search"], "targets": "quantiles"},
    "percentages": {
        "problems": [POOLED, {"name": "engineering-spring"}],
        "optimizers": ["gwo", "random-search"],
        "targets": ["50%", "5%"],
    },
    "tolerance": {"problems": [{"name": "signature-08"}], "optimizers": ["gwo", "alo"], "targets": "tolerance"},
    "bbob": {
        "problems": [{"suite": "bbob", "functions": [1, 8, 20], "dimensions": [2, 3], "instances": [1, 2]}],
        "optimizers": ["cma-es", "random-search", "gwo"],
        "budget": "50 * d",
    },
    "signature": {"problems": [{"names": ["signature-03", "signature-20"]}], "optimizers": ["gwo", "cma-es", "alo"]},
}


@pytest.mark.slow  # one study with most of what these have is above
@pytest.mark.parametrize("name", STUDIES)
def test_every_value_that_it_makes_is_that_of_the_report_of_other_studies(name, tmp_path, reproduce):
    study = {"name": name, "trials": 6, "budget": 300} | STUDIES[name]
    study["optimizers"] = [{"name": each} for each in study["optimizers"]]
    made = run(Study.from_dict(study), tmp_path / name, jobs=1).folder
    write_report(made, jobs=1)
    code, printed = reproduce(made)
    assert code == 0
    assert int(printed.splitlines()[-1].split()[0].replace(",", "")) > 20


def test_near_ties_are_merged_along_their_chain(folder):
    merge = runpy.run_path(str(folder / "reproduce.py"))["merge"]
    values = np.array([3.0, 1.0, 1.0 + 0.8e-10, 1.0 + 1.6e-10, np.inf, 2.0])
    assert merge(values).tolist() == [3.0, 1.0, 1.0, 1.0, np.inf, 2.0]
