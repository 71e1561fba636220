"""Table 7.2 and Fig. 7.4 of a study, beside the published numbers."""

from functools import cache

import numpy as np
import pandas as pd
import pytest

from bench import Results, Trace
from bench.folder import Folder
from bench.report import Figure, Table
from bench.study import Entry, Study
from problems.report import amplitudes, fitting_errors, sections

SWARMS = ("alo", "goa", "da", "gwo")


def make(folder, *, name="thesis", optimizers=(*SWARMS, "cma-es"), datasets=(3, 4), trials=6, factor=1.0, expected=True,
         unit="rpm", fail=(), budget=60_000):  # fmt: skip
    """Write a study whose swarms reach ``factor`` times the published mean of every dataset, exactly on average."""
    problems = tuple(Entry(f"signature-{k:02d}", f"signature-{k:02d}", {"unit": unit}) for k in datasets)
    study = Study(name, problems, tuple(Entry(o, f"my {o}") for o in optimizers), trials=trials, budget=budget)
    table = fitting_errors.published()
    place = Folder(folder)
    place.claim(study)
    with place.store.writer() as writer:
        for trial in study.plan():
            plugin, dataset = trial.optimizer.removeprefix("my "), int(trial.problem[-2:])
            mean = factor * table.at[dataset, plugin] if plugin in table else 2.0
            value = mean * (1 + 0.01 * (trial.number - (trials - 1) / 2))
            truth = 10.0 * dataset
            found = truth - (1.0 if plugin == "cma-es" else 3.0)
            figures = {"amplitude_rpm": found} | ({"amplitude_error_rpm": found - truth} if expected else {})
            row = {
                "status": "ok", "fun": value, "nfev": 10, "wall_s": 1.0, "cpu_s": 1.0, "objective_s": 0.5,
                "stop": "budget", "outside_box": 0, "x": {}, "figures": figures,
                "trace": Trace(np.array([1]), np.array([value])),
            }  # fmt: skip
            writer.add(trial, {"status": "failed", "error": "x"} if trial.key in fail else row)
    return Results(folder)


views = cache(sections)


def table(results, name):
    return next(item for section in views(results) for item in section.items if item.name == name)


def words(results):
    return " ".join(text for section in views(results) for text in section.text)


def test_the_published_table_is_whole():
    published = fitting_errors.published()
    assert list(published.index) == list(range(3, 21))
    assert list(published.columns) == list(SWARMS)
    assert published.notna().all(axis=None)
    assert published.sum().round(3).to_dict() == {"alo": 157.121, "goa": 259.768, "da": 223.586, "gwo": 136.255}


def test_table_7_2_has_the_thesis_columns_in_order_by_plugin_name(tmp_path):
    shown = table(make(tmp_path / "s", optimizers=("cma-es", "gwo", "da", "random-search", "goa", "alo")), "table-7-2")
    assert list(shown.frame.columns) == ["ALO", "GOA", "DA", "GWO", "CMA-ES"]
    assert shown.frame.index.tolist() == [3, 4]
    assert shown.frame.loc[3].tolist() == pytest.approx([2.777, 4.781, 3.227, 2.637, 2.0])


def test_bold_and_italics_compare_the_swarms_alone(tmp_path):
    shown = table(make(tmp_path / "s", datasets=(4,)), "table-7-2")  # ALO 3.331 and GWO 3.278 overlap, CMA-ES is at 2
    assert shown.bold.loc[4].to_dict() == {"ALO": False, "GOA": False, "DA": False, "GWO": True}
    assert shown.italic.loc[4].to_dict() == {"ALO": True, "GOA": False, "DA": False, "GWO": False}
    assert [cell.bold for cell in shown.rows[0]] == [False, False, False, False, True, False]


def test_exact_reproduction_is_said_in_words(tmp_path):
    results = make(tmp_path / "s", datasets=range(3, 21))
    assert "Of 72 cells shared with the published Table 7.2, 72 lie within 35% of the published mean." in words(results)
    assert "holds in 16 of 18 rows; in the published table it holds in 16 of these." in words(results)
    assert "Both are means over 30 trials" not in words(results)
    beside = table(results, "table-7-2-published").frame
    assert len(beside.columns) == 12
    np.testing.assert_allclose(beside.filter(like="diff"), 0, atol=1e-9)


def test_differences_are_relative_to_the_published_mean(tmp_path):
    results = make(tmp_path / "s", factor=1.5, budget=1000)
    np.testing.assert_allclose(table(results, "table-7-2-published").frame.filter(like="diff"), 50)
    assert "0 lie within 35%" in words(results)
    assert "The median relative difference is +50.0%, its median size 50.0%." in words(results)
    assert "so they need not agree" in words(results)


def test_published_conditions_are_said():
    study = Study("thesis", (), (), trials=30, budget=60_000)
    assert fitting_errors.conditions(study) == "Both are means over 30 trials of 60,000 evaluations."


def test_a_failed_trial_leaves_its_cell_without_a_mean(tmp_path):
    results = make(tmp_path / "s", fail=[("signature-03", "my alo", 0)])
    assert np.isnan(table(results, "table-7-2").frame.at[3, "ALO"])
    assert "Of 7 cells" in words(results)
    assert "Without a mean, as trials failed or are missing: ALO on dataset 3." in words(results)


@pytest.mark.parametrize(
    "change", [{"name": "my-study"}, {"optimizers": ("gwo",)}, {"optimizers": ("gwo", "cma-es"), "trials": 1}]
)
def test_smaller_studies_have_what_they_can(tmp_path, change):
    results = make(tmp_path / "s", **change)
    assert table(results, "table-7-2").frame["GWO"].notna().all()
    assert ("published" in words(results)) == ("name" not in change)


@pytest.mark.parametrize("change", [{"unit": "rps"}, {"optimizers": ("random-search",)}])
def test_no_table_7_2_in_another_unit_or_without_its_algorithms(tmp_path, change):
    names = [item.name for section in sections(make(tmp_path / "s", **change)) for item in section.items]
    assert "table-7-2" not in names
    assert "amplitude-dots" in names


def test_amplitude_errors_by_hand(tmp_path):
    results = make(tmp_path / "s", fail=[("signature-03", "my cma-es", 0), ("signature-04", "my cma-es", 1)])
    errors = table(results, "amplitude-errors").frame
    assert errors.loc["my gwo"].to_dict() == {
        "trials": 12,
        "mean error": -3.0,
        "median error": -3.0,
        "within band %": 0.0,
    }
    assert errors.loc["my cma-es", ["trials", "mean error"]].tolist() == [12, -1.0]
    assert errors.loc["my cma-es", "within band %"] == pytest.approx(100 * 10 / 12)
    assert "lie 83% of the trials of my cma-es" in words(results)
    assert "Of the 48 finished trials outside it, 100% underestimate" in words(results)
    by_dataset = table(results, "amplitude-within-band-by-dataset").frame
    assert by_dataset.loc["signature-03"].tolist() == pytest.approx([0, 0, 0, 0, 100 * 5 / 6])


def test_the_band_is_half_of_delta_a():
    assert pytest.approx(3.8672 / 2) == amplitudes.TOLERANCE_RPM


def test_both_forms_of_fig_7_4_carry_every_trial_and_the_expected_amplitude(tmp_path):
    results = make(tmp_path / "s")
    figures = [item for section in sections(results) for item in section.items if isinstance(item, Figure)]
    assert [figure.name for figure in figures] == ["amplitude-dots", "amplitude-boxes"]
    assert len(figures[0].figure.axes) == 5
    assert len(figures[0].data) == len(results.frame)
    assert figures[0].data.groupby("problem", observed=True)["expected_rpm"].first().tolist() == [30.0, 40.0]
    lines = {line.get_label() for line in figures[0].figure.axes[0].lines}
    assert {"expected amplitude", "accuracy band"} <= lines


def test_without_an_expected_amplitude_there_are_figures_but_no_errors(tmp_path):
    items = [item for section in sections(make(tmp_path / "s", expected=False, unit="rps")) for item in section.items]
    assert all(isinstance(item, Figure) for item in items)
    assert "No expected amplitude is known" in words(Results(tmp_path / "s"))


def test_a_study_of_other_problems_gets_nothing(tmp_path):
    study = Study("other", (Entry("p", "p"),), (Entry("gwo", "gwo"),), trials=1)
    place = Folder(tmp_path / "s")
    place.claim(study)
    with place.store.writer() as writer:
        for trial in study.plan():
            writer.add(trial, {"status": "failed", "error": "x"})
    assert sections(Results(tmp_path / "s")) == []


def test_only_problems_with_an_amplitude_are_drawn(tmp_path):
    frame = pd.DataFrame(
        {
            "problem": pd.Categorical(["a", "b", "b"], categories=["b", "a"]),
            "optimizer": pd.Categorical(["o"] * 3), "trial": [0, 0, 1], "status": ["ok", "ok", "failed"],
            "amplitude_rpm": [None, 5.0, None], "amplitude_error_rpm": [None, -1.0, None],
        }
    )  # fmt: skip
    data = amplitudes.amplitudes(frame)
    assert data["problem"].tolist() == ["b", "b"]
    assert data["expected_rpm"].tolist() == [6.0, 6.0]


def test_every_table_can_be_written(tmp_path):
    for section in sections(make(tmp_path / "s", fail=[("signature-03", "my gwo", 0)])):
        for item in section.items:
            if isinstance(item, Table):
                assert item.rows
