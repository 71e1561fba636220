"""The overview of a suite: functions of two groups in two dimensions, of two instances each."""

from itertools import product

import numpy as np
import pytest

from bench import Results, Study, run
from bench.analysis.compare import table as table_of
from bench.report.latex import to_latex
from bench.topics import write_report
from bench.topics.datasets import section as datasets
from bench.topics.findings import Findings
from bench.topics.integrity.checks import checks
from bench.topics.ranks.tables import rank_map
from bench.topics.suite import section as suite


@pytest.fixture(scope="module")
def findings(tmp_path_factory):
    table = {"suite": "classical", "functions": ["sphere", "rastrigin"], "dimensions": [2, 5], "instances": "1-2"}
    study = Study.from_dict(
        {"name": "suite", "trials": 3, "budget": "200 * d", "problems": [table],
         "optimizers": [{"name": "cma-es-fast"}, {"name": "random-search"}]}
    )  # fmt: skip
    return Findings(Results(run(study, tmp_path_factory.mktemp("run") / "s", n_jobs=1).folder))


@pytest.fixture(scope="module")
def items(findings):
    return {item.name: item for item in suite.section(findings).items}


def test_instances_are_pooled(findings):
    assert findings.trials.problems == [f"classical-{each}-d{d}" for each in ("sphere", "rastrigin") for d in (2, 5)]
    assert findings.trials.per_cell == (6, 6)
    assert set(findings.trials.optima.values()) == {0.0}
    assert findings.trials.budgets == {label: 200 * d for label, d in findings.trials.dimensions.items()}


def test_the_checks_count_instances_and_problems_each_by_its_name(findings, monkeypatch):
    again = Findings(findings.results)
    assert len(again.trials.pooled.members) == 4
    monkeypatch.setattr(Results, "frame", findings.results.frame.assign(fun=1.0))  # every cell has ties alone
    said = again.of(checks).set_index("check").at["ties", "finding"]
    assert "cma-es-fast on 8 instances of 4 problems, random-search on 8 instances of 4 problems" in said


def test_who_reached_the_most_targets_is_said_first(findings, items):
    first, _ = suite.section(findings).text
    curves = items["targets-by-group"].data
    ends = curves[np.isclose(curves["per_dimension"], 200)]  # the budget; simulated restarts go on
    shares = ends[ends["problem"] == "all functions, d = 5"].set_index("optimizer")["fraction"]
    assert first.startswith("Within the whole budget, the most targets were reached by ")
    assert f"5 ({shares.max():.0%})" in first
    assert shares.idxmax() in first


@pytest.mark.parametrize(
    ("evaluations", "said"),
    [
        (1.0, "reached by cma-es-fast and random-search in dimension 2 (100%) and 5 (100%)."),
        (np.inf, "No trial reached a target."),
    ],
)
def test_all_who_reached_the_most_targets_are_named_and_nobody_where_none_was(findings, evaluations, said):
    again = Findings(findings.results)
    again.anytime.__dict__["hits"] = findings.anytime.hits.assign(evaluations=evaluations)
    assert suite.section(again).text[0].endswith(said)


def test_ranks_are_given_by_group_and_dimension(findings, items):
    table = items["ranks-by-group"].frame
    ranks = table_of(findings.final.standings, "rank")
    assert table["problems"].tolist() == [2, 2, 1, 1, 1, 1]
    assert table.loc["all functions, d = 5", "cma-es-fast"] == pytest.approx(
        ranks.loc[["classical-sphere-d5", "classical-rastrigin-d5"], "cma-es-fast"].mean()
    )


def test_one_rule_ranks_everywhere(findings, items):
    """The ranks by group were those of medians, and differed from the figure and the ranking of the same page."""
    by_group, of_all = items["ranks-by-group"].frame, findings.final.ranking.set_index("optimizer")["mean_rank"]
    overall = by_group.loc[["all functions, d = 2", "all functions, d = 5"], list(of_all.index)]
    assert overall.mean().to_dict() == pytest.approx(of_all.to_dict())
    last = (
        findings.anytime.stages[findings.anytime.stages["share"] == 1.0]
        .groupby("optimizer", observed=True)["rank"]
        .mean()
    )
    assert last.to_dict() == pytest.approx(of_all.to_dict())


def test_the_map_of_a_suite_has_a_row_a_function(findings, monkeypatch):
    monkeypatch.setattr("bench.topics.findings.trials.MANY_PROBLEMS", 3)
    found = rank_map(findings)
    first, second = findings.final.ranked
    assert list(found.frame) == [f"{name}, d = {d}" for name in (first, second) for d in (2, 5)]
    assert list(found.frame.index) == ["sphere", "rastrigin"]
    ranks = table_of(findings.final.standings, "rank")
    for function, d, optimizer in product(found.frame.index, (2, 5), (first, second)):
        shown = float(found.frame.at[function, f"{optimizer}, d = {d}"])
        assert shown == ranks.at[f"classical-{function}-d{d}", optimizer]
    assert (found.bold.shape, found.shades.shape, found.marks.shape) == ((2, 4),) * 3


def test_running_times_are_shown_over_the_dimension(findings, items):
    table = items["scaling"].data.set_index(["problem", "dimension", "optimizer"])["ert"]
    hits = findings.anytime.hits
    own = hits[(hits["problem"] == "classical-sphere-d5") & (hits["optimizer"] == "cma-es-fast")]
    own = own[np.isclose(own["tau"], 1e-2)]
    reached = np.isfinite(own["evaluations"])
    expected = np.where(reached, own["evaluations"], own["spent"]).sum() / reached.sum() / 5
    assert table["classical sphere", 5, "cma-es-fast"] == pytest.approx(expected)


def test_functions_have_their_own_curves_and_one_table_a_dimension(findings):
    first, second = suite.section(findings).sections
    assert [first.title, second.title] == [f"Function by function in dimension {d}" for d in (2, 5)]
    curves, table = second.items
    assert curves.name == "targets-by-function-d5"
    assert curves.data["problem"].unique().tolist() == ["sphere, d = 5", "rastrigin, d = 5"]
    assert table.name == "running-times-d5"
    assert table.frame.index.tolist() == [
        (each, label) for each in ("sphere", "rastrigin") for label in findings.trials.optimizers
    ]
    times = findings.anytime.running_times.set_index(["problem", "optimizer", "precision"])
    ert = times.at[("classical-sphere-d5", "cma-es-fast", 10.0), "ert"]
    assert table.frame.at[("sphere", "cma-es-fast"), "10"].startswith(f"{ert:,.0f} (")
    assert table.frame.at[("rastrigin", "random-search"), "1e-08"] == "∞ (1,000)"
    assert table.frame.at[("rastrigin", "random-search"), "successes"] == "0/6"
    assert not table.marks.loc[("sphere", "random-search")].any()
    assert r"\begin{tabular}" in to_latex(table, "t")


def test_a_suite_without_a_target_has_its_ranks_alone(findings):
    again = Findings(findings.results)
    again.anytime.__dict__["hits"] = findings.anytime.hits[:0]
    section = suite.section(again)
    assert [item.name for item in section.items] == ["ranks-by-group"]
    assert section.text[0] == "No trial has a target."


def test_the_suite_begins_with_the_targets_of_all_functions(findings):
    figure = suite.section(findings).items[0]
    assert figure.name == "targets-of-all"
    assert figure.data["problem"].unique().tolist() == ["all functions, d = 2", "all functions, d = 5"]
    crosses = [line for ax in figure.figure.axes for line in ax.lines if line.get_marker() == "x"]
    assert {float(line.get_xdata()[0]) for line in crosses} == {200.0}  # evaluations / d, where restarts begin
    assert "Crosses: the end of the budget" in figure.caption


def test_the_running_times_of_two_are_scattered(findings, items):
    table = items["ert-scatter"].data
    assert set(findings.final.ranked[:2]) <= set(table)
    assert set(table["kind"]) == {"d = 2", "d = 5"}


@pytest.mark.slow
def test_of_many_problems_no_single_one_has_a_latex_file(findings, tmp_path, monkeypatch):
    monkeypatch.setattr("bench.topics.findings.trials.MANY_PROBLEMS", 3)
    tables = write_report(findings.results.paths[0], output=tmp_path / "out", n_jobs=1).parent / "tables"
    assert (tables / "running-times-d2.tex").exists()
    assert not list(tables.glob("cells-*.tex"))
    figures = tables.with_name("figures")
    assert list(figures.glob("distribution-*.svg"))
    assert not list(figures.glob("distribution-*.pdf"))
    assert list(tables.glob("cells-*.csv"))


def test_a_study_of_one_kind_has_no_overview(make, tmp_path):
    assert suite.section(Findings(Results(make(tmp_path / "s")))) is None


def test_a_function_s_own_section_has_its_expected_running_times(findings):
    (own, *_) = datasets.section(findings).sections
    table = next(item for item in own.items if item.name == "running-times-classical-sphere-d2")
    shown, times = table.frame, findings.anytime.running_times.set_index(["problem", "optimizer", "precision"])
    assert list(shown) == ["10", "1", "0.1", "0.01", "0.001", "1e-05", "1e-07", "1e-08", "95%", "ERT / d",
                           "seconds", "successes"]  # fmt: skip
    assert shown.loc["cma-es-fast", "10"] == times.loc[("classical-sphere-d2", "cma-es-fast", 10.0), "ert"]
    assert shown.loc["random-search", "successes"] == "0/6"
