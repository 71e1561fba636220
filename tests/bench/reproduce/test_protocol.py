"""The study that repeats a table, and our samples on the table's scale."""

import numpy as np
import pytest

import bench
from bench.reproduce.protocol import protocol_of, samples
from bench.reproduce.table import read
from tests.bench.reports import ended, store

HEAD = "# suite = 'classical'\n# runs = 4\n# dimension = 2\n"
ROWS = "function,optimizer,budget,mean\nsphere,random-search,40,1\nackley,random-search,40,2\n"


def table(tmp_path, text):
    (tmp_path / "paper.csv").write_text(text, encoding="utf-8")
    return read(tmp_path / "paper.csv")


def test_the_study_has_the_table_s_runs_budget_problems_and_optimizers(tmp_path):
    made = protocol_of(table(tmp_path, f"{HEAD}{ROWS}sphere,GWO,40,3\n"))
    study = made.study
    assert (study.name, study.trials, study.budget.evaluations(2)) == ("paper", 4, 40)
    assert [entry.name for entry in study.problems] == ["classical-sphere-d2-i1", "classical-ackley-d2-i1"]
    assert [(entry.name, entry.label) for entry in study.optimizers] == [
        ("random-search", "random-search"), ("gwo", "GWO"),
    ]  # fmt: skip
    assert protocol_of(table(tmp_path, f"{HEAD}{ROWS}"), trials=9).study.trials == 9


def test_cells_that_cannot_be_run_say_why_and_the_others_are(tmp_path):
    others = "sphere,Unheard,40,3\nunheard,GWO,40,3\nlevy,GWO,50,3\nlevy,random-search,,3\nlevy,random-search,many,3\n"
    text = f"{HEAD}{ROWS}{others}"
    made = protocol_of(table(tmp_path, text))
    assert len(made.cells) == 2
    assert [reason.partition(";")[0].partition(" or a")[0] for reason in made.reasons.values()] == [
        "no optimizer is called 'Unheard'",
        "classical has no function 'unheard'",
        "its budget is another one than that of line 5 in this dimension: such cells belong into a table of their own",
        "the budget is not printed",
        "its budget must be a whole number from 1 to 1e+15",
    ]


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Return the results of a study like the table's, whose trials end at 0.5 and more above the optimum."""
    place = tmp_path_factory.mktemp("protocol")
    study = protocol_of(table(place, f"{HEAD}{ROWS}")).study

    def row_of(trial):
        return ended(bench.load_problem(trial.problem).optimum + 0.5 + trial.number, x={"x1": 1.0, "x2": 1.0})

    return bench.Results(store(place / "run", study, row_of))


def test_samples_are_errors_where_the_table_prints_errors(tmp_path, results):
    paper = table(tmp_path, f"# values = 'error'\n{HEAD}{ROWS}")
    found = samples(paper, made := protocol_of(paper), results)
    assert not made.reasons
    assert len(found) == 2
    for values in found.values():
        np.testing.assert_allclose(sorted(values), [0.5, 1.5, 2.5, 3.5])
