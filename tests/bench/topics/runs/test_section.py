"""The section on every run: the axis that panels share, marks, medians with tests, and the map of ranks."""

import numpy as np
import pytest

from bench import Results, Study, run
from bench.topics.findings import Findings
from bench.topics.runs.marks import FIRST, marks
from bench.topics.runs.panels import measured
from bench.topics.runs.section import section


@pytest.fixture(scope="module")
def folder(make, tmp_path_factory):
    """Return a folder in which a, b and c find about 5, 6 and 7 on p and q."""
    return make(tmp_path_factory.mktemp("runs") / "s")


@pytest.fixture(scope="module")
def suite(tmp_path_factory):
    """Return the findings of two functions in two dimensions, of two instances each."""
    table = {"suite": "classical", "functions": ["sphere", "rastrigin"], "dimensions": [2, 5], "instances": "1-2"}
    study = Study.from_dict(
        {"name": "suite", "trials": 3, "budget": "100 * d", "problems": [table],
         "optimizers": [{"name": "cma-es-fast"}, {"name": "random-search"}]}
    )  # fmt: skip
    return Findings(Results(run(study, tmp_path_factory.mktemp("suite") / "s", n_jobs=1).folder))


def found(folder, **optima):
    findings = Findings(Results(folder))
    findings.trials.__dict__["optima"] = optima
    return findings


class TestTheAxis:
    def test_has_ratios_where_values_are_positive(self, folder):
        of_all = measured(found(folder))
        assert (of_all.axis, of_all.logarithmic) == ("value / lowest", False)
        assert of_all.frame.groupby("problem", observed=True)["value"].min().tolist() == [1.0, 1.0]
        known = measured(found(folder, p=2.0)).frame
        assert known.loc[known["problem"] == "p", "value"].min() == pytest.approx(
            known.loc[known["problem"] == "p", "fun"].min() / 2
        )

    def test_has_distances_where_values_are_not(self, make, tmp_path):
        of_all = measured(found(make(tmp_path / "s", changes={"a": {"fun": -1.0}})))
        assert of_all.logarithmic
        assert of_all.frame["value"].min() == 1e-6
        assert of_all.frame.groupby("problem", observed=True)["value"].median().tolist() == pytest.approx([1, 1])

    def test_has_precisions_on_functions_of_the_field(self, suite):
        of_all = measured(suite)
        assert (of_all.axis, of_all.logarithmic) == ("precision", True)
        assert of_all.frame["value"].min() >= 1e-8


class TestMarks:
    def test_the_first_and_those_that_no_test_separates_from_it(self, folder):
        shown = marks(found(folder).final, {"p": ["p"], "both": ["p", "q"]})
        assert shown.loc["p"].to_dict() == {"a": FIRST, "b": "", "c": ""}
        assert shown.loc["both"].to_dict() == {"a": FIRST, "b": "", "c": ""}


class TestTheSection:
    def test_has_one_figure_with_the_medians_behind_it(self, folder):
        findings = found(folder, p=2.0)
        made = section(findings)
        figure, best = made.items
        assert (best.name, best.data["problem"].tolist()) == ("best-points", ["p", "q"])
        table = figure.table
        assert (figure.name, table.name, len(figure.data)) == ("every-run", "comparison", 48)
        assert table.frame.index.tolist() == ["p", "q"]
        assert table.typography.bold.loc["p"].to_dict() == {"a": True, "b": False, "c": False}
        assert table.typography.marks.loc["p"].to_dict() == {"a": "", "b": "1.00*", "c": "1.00*"}
        data = table.data.set_index(["problem", "optimizer"])
        assert data.at[("p", "b"), "median_above_optimum"] == pytest.approx(data.at[("p", "b"), "median"] - 2)
        assert np.isnan(data.at[("q", "b"), "median_above_optimum"])
        assert {"a12", "p", "p_holm", "mean", "rank"} <= set(data)
        assert made.text == (
            "Tests find a difference on 2 of 2 problems; of 2 problems without any difference, 0.1 would show one.",
        )
        assert {file.path for file in made.files} == {f"tables/{name}.csv" for name in ("trials", "tests", "ranking")}
