"""The best of 2009 beside optimizers: made-up times on f08 in two dimensions, of two instances each."""

from importlib.util import find_spec

import numpy as np
import pandas as pd
import pytest

from bench import BenchError, Results, load_problem
from bench.topics.anytime import best
from bench.topics.datasets import section as datasets
from bench.topics.findings import Findings
from bench.topics.findings import anytime as findings_module
from tests.bench.formats.made import BUDGET, make, record

pytestmark = pytest.mark.skipif(not find_spec("cocoex"), reason="bbob's optima are computed by coco-experiment")

PROBLEMS = {f"bbob-f08-d{d}-i{i}": d for d in (2, 5) for i in (1, 2)}
KNOWN = pd.DataFrame(
    {
        "problem": ["bbob-f08-d2"] * 3 + ["bbob-f08-d5"],
        "precision": [10.0, 1e-2, 1e-8, 10.0],
        "ert": [5.0, 10.0, 20.0, 40.0],
    }
)


def row(trial, _values):
    """Optimizer a reaches 1e-2 with evaluation 8 in 2 dimensions; b never reaches 10; in 5, both reach 10 with 80."""
    optimum = load_problem(trial.problem).optimum
    values = np.full(BUDGET, 99.0)
    if trial.optimizer == "a":
        values[7 if "-d2-" in trial.problem else 79 :] = 1e-3
    elif "-d5-" in trial.problem:
        values[79:] = 5.0
    return record(values + optimum, PROBLEMS[trial.problem])


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return Results(make(tmp_path_factory.mktemp("best") / "s", PROBLEMS, trials=2, row=row).paths[0])


@pytest.fixture
def beside(results, monkeypatch):
    def found(asked="precisions", known=KNOWN):
        monkeypatch.setattr(findings_module, "best2009", lambda names: known)
        return Findings(results, asked, beside_best=True)

    return found


def test_the_tables_have_its_times(beside):
    found = beside()
    times = found.anytime.running_times.set_index(["problem", "optimizer", "precision"])["best2009"]
    assert times["bbob-f08-d2", "a"].loc[[10.0, 1.0, 1e-2, 1e-8]].tolist() == [5.0, 10.0, 10.0, 20.0]
    assert times["bbob-f08-d5", "b"].loc[[10.0, 1.0]].tolist() == [40.0, np.inf]
    (table,) = [each for each in datasets.section(found).sections[0].items if "running-times" in each.name]
    assert table.frame.loc["best of 2009", ["10", "1e-08"]].tolist() == [5.0, 20.0]
    assert table.frame.loc["best of 2009", "successes"] == ""
    assert not table.bold.loc["best of 2009"].any()
    assert len(table.rows) == 3


def test_curves_have_its_share_of_targets(beside):
    curves = beside([50.0, 1.0]).anytime.restarts_per_dimension
    own = curves[(curves["optimizer"] == "best of 2009") & (curves["problem"] == "bbob-f08-d2")]
    assert own.set_index("per_dimension")["fraction"].asof([2.4, 2.9, 5.9]).tolist() == [0.0, 0.5, 1.0]  # 5 and 10 / d
    other = Findings(beside().results, [50.0, 1.0]).anytime.restarts_per_dimension
    assert "best of 2009" not in set(other["optimizer"])


def test_the_ratios_are_given_by_dimension_and_target(beside):
    section = best.section(beside())
    table = section.items[0].frame
    assert table.index.tolist() == ["d = 2, precision = 1", "d = 2, precision = 0.01", "d = 2, precision = 1e-08"]
    assert table["a"].tolist() == [0.8, 0.8, np.inf]
    assert np.isinf(table["b"]).all()
    assert table["problems"].tolist() == [1, 1, 1]
    said = section.text[1]
    assert said.startswith("To precision = 1, a needed no more evaluations than the best of 2009 on 1 of 1 problem. ")
    assert said.endswith(
        "To precision = 1e-08, every optimizer needed more evaluations than the best of 2009 on 1 problem."
    )


def test_a_list_of_precisions_has_its_own_levels(beside):
    found = best.section(beside([50.0, 9.9]))
    assert found.items[0].frame.index.tolist() == [
        "d = 2, precision = 50",
        "d = 2, precision = 9.9",
        "d = 5, precision = 50",
    ]
    assert found.items[0].frame["b"].tolist() == [np.inf, np.inf, 2.0]


def test_problems_without_a_time_are_counted(beside):
    section = best.section(beside(known=KNOWN[:3]))
    assert section.text[-1] == "1 problem without such a time, or whose optimum was beaten, are left out."


def test_where_every_optimum_is_beaten_nothing_is_compared(beside):
    found = beside()
    found.trials.__dict__["unbeaten"] = {}
    section = best.section(found)
    assert section.items == ()
    assert section.text[-1].startswith("2 problems without such a time")


def test_other_targets_than_precisions_are_refused(beside):
    with pytest.raises(BenchError, match="the targets are quantiles; add --targets precisions or leave out best2009"):
        beside("quantiles").anytime.check_targets()
