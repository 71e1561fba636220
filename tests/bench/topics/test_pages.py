"""A whole page and the answers of small studies, compared with committed ones; ``pytest --update`` writes them anew.

The pages hold the sentences; tests beside the topics hold numbers, bad input and what no page shows.
"""

from importlib.util import find_spec

import numpy as np
import pandas as pd
import pytest

from bench import Results, Study, load_problem
from bench.storage.folder import Folder
from bench.topics.findings import Findings
from tests.bench.reports import finished, store
from tests.bench.topics.methods.records import RECORD
from tests.bench.topics.page_text import answer_text, page_text

STUDIES = {}
WHOLE = "clear-winner"  # of which the whole page is compared, and of the others the first two sections


def page(build):
    """Have a study among those whose pages are compared, under the name of the function that builds it."""
    STUDIES[build.__name__.replace("_", "-")] = build
    return build


@page
def clear_winner(make, folder):
    return Findings(Results(make(folder)))


@page
def too_few_trials(make, folder):
    return Findings(Results(make(folder, problems=("p",), trials=2)))


@page
def failed_and_missing(make, folder):
    """One cell and one trial failed, a cell and a trial are missing, a problem's code raised; a waited and clamps."""
    waited = {"wall_s": 2.0, "cpu_s": 1.0, "nfev": 60, "stop": "undeclared", "outside_box": 60}
    make(
        folder, ("p", "q", "r", "s"), fail=[("p", "b"), ("q", "a", 1)], skip=[("q", "c"), ("p", "a", 7)],
        raised=[("r", "a", 0)], changes={"a": waited},
    )  # fmt: skip
    noted = {
        "a": [("centre bias", False, 4e5), ("structural bias", False, 5e-10), ("starts and seeds", True, None)],
        "b": [("centre bias", True, 0.9), ("structural bias", True, 0.4), ("boundary clamping", True, 0.0)],
    }
    names, rest = ("check", "passed", "figure"), {"kind": "trait", "finding": "", "remedy": "", "code": ""}
    checks = {label: [rest | dict(zip(names, each, strict=True)) for each in own] for label, own in noted.items()}
    Folder(folder).note("checks.json", checks)
    return Findings(Results(folder))


def ends_at(levels, nfev=100):
    """Return the function that makes a trial's row: it ends above the optimum, by its optimizer's level."""

    def row_of(trial):
        problem = load_problem(trial.problem)
        value = (problem.optimum or 0.0) + levels[trial.optimizer] + 0.01 * trial.number
        spent = nfev.get(trial.optimizer, 100) if isinstance(nfev, dict) else nfev
        rng = np.random.default_rng(trial.number)
        row = finished(value, rng) | {"nfev": spent, "stop": "tolfun"}
        return row | {"x": dict(zip(problem.variables, rng.random(problem.dimension), strict=True))}

    return row_of


@page
def unlike_conditions(make, folder):
    """Optimizers under unlike conditions; gwo leaves a part of its budget."""
    levels = {"cma-es": 0.001, "gwo": 0.015, "random-search": 40.0}
    table = [
        {"name": "cma-es", "agents": 9, "handling": "box", "start": "midpoint"}, {"name": "gwo", "agents": 9},
        {"name": "random-search", "agents": 9},
    ]  # fmt: skip
    problems = [{"names": ["classical-sphere-d2-i1", "classical-ackley-d3-i1"]}]
    study = {"name": "made", "trials": 6, "budget": 100, "problems": problems, "optimizers": table}
    store(folder, Study.from_dict(study), ends_at(levels, {"gwo": 72}), record=RECORD)
    return Findings(Results(folder))


@page
def subject(make, folder):
    """A subject that the first run named, on pooled instances, with too few trials for tests on problems.

    It beats random search in every pair of trials, and loses to cma-es, which left a third of its budget.
    """
    pooled = {"suite": "classical", "functions": ["sphere", "rastrigin"], "dimensions": [2, 3], "instances": "1-2"}
    labels = ["gwo", "cma-es", "alo", "random-search"]
    study = Study.from_dict(
        {"name": "made", "trials": 5, "budget": 100, "problems": [pooled], "subject": "gwo",
         "optimizers": [{"name": label} for label in labels]}
    )  # fmt: skip
    row_of = ends_at({"gwo": 0.03, "cma-es": 0.0, "alo": 0.04, "random-search": 40.0}, {"cma-es": 64})
    store(folder, study, row_of, record=RECORD | {"subject": "gwo"})
    return Findings(Results(folder))


@page
def beside_the_best_of_2009(make, folder):
    """Two functions of BBOB beside the best times, with gwo as the reference of the competition's table."""
    suite = {"suite": "bbob", "functions": [1, 8], "dimensions": [2, 5], "instances": "1-2"}
    study = Study.from_dict(
        {"name": "made", "trials": 3, "budget": 100, "problems": [suite], "targets": "precisions",
         "optimizers": [{"name": "random-search"}, {"name": "gwo"}]}
    )  # fmt: skip
    store(folder, study, ends_at({"gwo": 1e-3, "random-search": 0.5}), record=RECORD)
    found = Findings(Results(folder), beside_best=True, asked_subject="gwo")
    vars(found.anytime)["best"] = BEST  # in place of an archive of 2009
    return found


BEST = pd.DataFrame(
    {
        "problem": ["bbob-f08-d2"] * 3 + ["bbob-f08-d5", "bbob-f01-d2"],
        "precision": [10.0, 1e-2, 1e-8, 10.0, 1e-2],
        "ert": [5.0, 10.0, 20.0, 40.0, 60.0],
    }
)


@pytest.mark.parametrize("name", STUDIES)
def test_the_texts_are_the_committed_ones(name, make, tmp_path, committed):
    if "2009" in name and not find_spec("cocoex"):
        pytest.skip("the optima of bbob are computed by coco-experiment")
    findings = STUDIES[name](make, tmp_path / "made")
    committed(name, page_text(findings) if name == WHOLE else answer_text(findings))
