"""Table 7.2 and Figs. 7.3 to 7.5 of a study, beside the published numbers and conclusions."""

from functools import cache

import numpy as np
import pandas as pd
import pytest

from bench import Results, load_problem
from bench.plots import style
from bench.report import Figure, Table
from bench.report.write import save_figure
from bench.study import Entry, Study
from bench.topics import Findings
from problems.backlash.report import (
    accuracy,
    amplitudes,
    fitting_errors,
    levels,
    noise,
    reference,
    sections,
)
from problems.backlash.signature.problem import TOLERANCE_RAD, TOLERANCE_RPM, Fit, SignatureFit
from tests.bench.reports import FAILED, ended, store
from tests.bench.storage.filled import change_data

SWARMS = ("alo", "goa", "da", "gwo")


@pytest.fixture(autouse=True)
def best_fit(monkeypatch):
    """Stand in for the search for the best fit, whose own tests are elsewhere."""
    monkeypatch.setattr(SignatureFit, "reference", lambda self, *, constrained=False: Fit(np.ones(7), 0.5))


@cache
def truth(level):
    expected = load_problem(f"signature-{level:02d}").expected
    return {figure: value for figure, (value, _) in expected.items()}


def make(folder, *, name="thesis", optimizers=(*SWARMS, "cma-es"), datasets=(3, 4), trials=6, factor=1.0, miss=None,
         unit="rpm", fail=(), budget=60_000):  # fmt: skip
    """Write a study whose swarms reach ``factor`` times the published mean of every dataset, exactly on average.

    By default CMA-ES underestimates every amplitude by 1 rpm and every swarm by 3; ``miss`` says it by plug-in.
    """
    problems = tuple(Entry(f"signature-{k:02d}", f"signature-{k:02d}", {"unit": unit}) for k in datasets)
    study = Study(name, problems, tuple(Entry(o, f"my {o}") for o in optimizers), trials=trials, budget=budget)
    table = fitting_errors.published()
    miss = miss or {"cma-es": lambda level, trial: -1.0}

    def row(trial):
        plugin, level = trial.optimizer.removeprefix("my "), int(trial.problem[-2:])
        mean = factor * table.at[level, plugin] if plugin in table else 2.0
        error = miss.get(plugin, lambda level, trial: -3.0)(level, trial.number)
        figures = {
            "amplitude_rpm": truth(level)["amplitude_rpm"] + error,
            "amplitude_error_rpm": error,
            "backlash_rad": truth(level)["backlash_rad"] + 5e-5 * error,
        }
        return ended(mean * (1 + 0.01 * (trial.number - (trials - 1) / 2)), metrics=figures)

    return write(folder, study, lambda trial: FAILED if trial.key in fail else row(trial))


def write(folder, study, row):
    return Results(store(folder, study, row))


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    return make(tmp_path_factory.mktemp("usual") / "s")


MODULES = {levels, fitting_errors, reference, amplitudes, noise}
HOLDERS = {"table": fitting_errors, "amplitude": amplitudes, "backlash": levels}


@cache
def views(results, *modules):
    """Return the sections of a study; of these modules alone where some are given, as figures take time."""
    with pytest.MonkeyPatch.context() as patch:
        for each in MODULES - {*(modules or MODULES)}:
            patch.setattr(each, "sections", lambda *_: [])
        return sections(Findings(results))


def table(results, name):
    holder = HOLDERS[name.partition("-")[0]]
    return next(item for section in views(results, holder) for item in section.items if item.name == name)


def words(results, *modules):
    return " ".join(text for section in views(results, *modules) for text in section.text)


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
    results = make(tmp_path / "s", datasets=range(3, 21), trials=30)
    said = words(results, fitting_errors)
    assert "Reproduced in 72 of 72 cells to within one SD (ours, where none is printed)." in said
    assert "holds in 16 of 18 rows; in the published table it holds in 16 of these." in said
    beside = table(results, "table-7-2-published").frame
    assert len(beside) == 72
    assert set(beside["verdict"]) == {"reproduced"}


def test_much_larger_means_differ_from_the_published_ones(tmp_path):
    results = make(tmp_path / "s", factor=5, trials=30)
    assert "Reproduced in 0 of 8 cells to within one SD; 8 differ: f3 (ALO higher, " in words(results, fitting_errors)


def test_another_budget_cannot_be_judged(tmp_path):
    said = words(make(tmp_path / "s", budget=1000), fitting_errors)
    assert "None of 8 cells can be judged." in said
    assert "Not judged: f3, ALO (line 12) and 7 more cells: the results have another budget." in said


def test_published_conditions_are_said():
    study = Study("thesis", (), (), trials=30, budget=60_000)
    assert noise.conditions(study) == "Both are means over 30 trials of 60,000 evaluations."


def test_a_failed_trial_leaves_its_cell_without_a_mean(tmp_path):
    results = make(tmp_path / "s", fail=[("signature-03", "my alo", 0)])
    assert np.isnan(table(results, "table-7-2").frame.at[3, "ALO"])
    assert "Not judged: f3, ALO (line 12): 1 of its 6 trials failed." in words(results, fitting_errors)


@pytest.mark.parametrize(
    "change", [{"name": "my-study"}, {"optimizers": ("gwo",)}, {"optimizers": ("gwo", "cma-es"), "trials": 1}]
)
def test_smaller_studies_have_what_they_can(tmp_path, change):
    results = make(tmp_path / "s", **change)
    assert table(results, "table-7-2").frame["GWO"].notna().all()
    assert ("cells" in words(results, fitting_errors)) == ("name" not in change)


@pytest.mark.slow
@pytest.mark.parametrize("change", [{"unit": "rps"}, {"optimizers": ("random-search",)}])
def test_no_table_7_2_in_another_unit_or_without_its_algorithms(tmp_path, change):
    names = [item.name for section in sections(Findings(make(tmp_path / "s", **change))) for item in section.items]
    assert "table-7-2" not in names
    assert "amplitude-dots" in names


def test_who_has_the_lowest_and_the_highest_mean_is_said_beside_the_published_ones(tmp_path):
    said = words(make(tmp_path / "s", datasets=(4, 7, 16)), fitting_errors)
    assert "Among the swarms GWO had the lowest mean on 2 of 3 problems and ALO on 1 (published: GWO had the " in said
    assert "lowest mean on 2 of 3 problems" in said.split("(published: ")[1]
    assert "GOA had the highest mean on 2 of 3 problems and DA on 1" in said


def test_the_share_of_pairs_told_apart_is_counted_from_the_tests():
    pairs = pd.DataFrame({"ks_p": [0.05, 0.01, 0.2, 0.051], "n_first": 30, "n_second": 30})
    study = Study("thesis", (), (), trials=30, budget=60_000)
    assert "of 2 of 4 pairs" in fitting_errors.swarm_tests(pairs, study)[0]
    assert fitting_errors.swarm_tests(pairs, study)[0].endswith("this run does not agree.")
    assert fitting_errors.swarm_tests(pairs[:3], study)[0].endswith("this run agrees.")
    assert fitting_errors.swarm_tests(pairs[:0], study) == ()


def test_too_few_trials_neither_agree_nor_disagree_with_the_thesis():
    pairs = pd.DataFrame({"ks_p": [1.0, 1.0], "n_first": 1, "n_second": 1})
    (said,) = fitting_errors.swarm_tests(pairs, Study("thesis", (), (), trials=1, budget=60_000))
    assert said.startswith("With 1 trial a cell no Kolmogorov-Smirnov test can be significant")
    assert "agree" not in said
    fewer = Study("thesis", (), (), trials=10, budget=9_000)
    (said,) = fitting_errors.swarm_tests(pairs.assign(n_first=10, n_second=10), fewer)
    assert "does not agree. This run has 10 trials of 9,000 evaluations, the thesis 30 of 60,000" in said


def test_the_thesis_s_words_on_da_are_held_to_its_own_table(usual):
    said = words(usual, fitting_errors)
    assert "The latter is not what its Table 7.2 shows: there GOA has the highest mean on 17 of 18 datasets" in said


def test_errors_that_cancel_are_not_called_accurate():
    def errors(**by_optimizer):
        rows = [(label, error) for label, own in by_optimizer.items() for error in own]
        data = pd.DataFrame(rows, columns=["optimizer", "error"])
        return data.assign(problem=pd.Categorical(["p"] * len(data)), expected=1.0, within=False)

    said = accuracy.signed_and_size(errors(a=[-20.0, 0.5, 20.0], b=[2.0, 2.0, 3.0]), " rpm")
    assert said == (
        "By the signed median error a looks the most accurate (+0.5 rpm), because its errors to both sides cancel. The "
        "median size of its error is 20.0 rpm, the largest of all; the smallest is that of b, 2.0 rpm."
    )
    assert accuracy.signed_and_size(errors(a=[1.0, 1.0], b=[2.0, 2.0]), "rpm") == ""
    assert accuracy.signed_and_size(errors(a=[1.0]), "rpm") == ""


def test_amplitude_errors_by_hand(tmp_path):
    results = make(tmp_path / "s", fail=[("signature-03", "my cma-es", 0), ("signature-04", "my cma-es", 1)])
    errors = table(results, "amplitude-errors").frame
    assert errors.loc["my gwo"].tolist() == pytest.approx([12, -3.0, -3.0, 3.0, 0.0])
    assert errors.loc["my cma-es"].tolist() == pytest.approx([12, -1.0, -1.0, 1.0, 100 * 10 / 12])
    assert "83% of my cma-es trials" in words(results, amplitudes)
    assert "trials are within the accuracy band of ±1.9336 rpm" in words(results, amplitudes)
    by_dataset = table(results, "amplitude-within-band-by-dataset").frame
    assert by_dataset.loc["signature-03"].tolist() == pytest.approx([0, 0, 0, 0, 100 * 5 / 6])


def test_backlash_errors_by_hand(tmp_path):
    results = make(tmp_path / "s", fail=[("signature-03", "my cma-es", 0)])
    errors = table(results, "backlash-errors").frame
    assert errors.loc["my gwo"].tolist() == pytest.approx([12, -150.0, -150.0, 150.0, 0.0])
    assert errors.loc["my cma-es"].tolist() == pytest.approx([12, -50.0, -50.0, 50.0, 100 * 11 / 12])
    assert "92% of my cma-es trials" in words(results, levels)
    assert "trials are within ±0.0001 rad of the true backlash." in words(results, levels)
    assert "1 trial of 60 gave no backlash" in words(results, levels)


def test_the_bands_are_half_of_delta_a_and_delta_delta():
    assert pytest.approx(3.8672 / 2) == TOLERANCE_RPM
    assert pytest.approx(0.0002 / 2) == TOLERANCE_RAD


def test_both_forms_of_fig_7_4_carry_every_trial_and_the_expected_amplitude(tmp_path):
    results = make(tmp_path / "s", fail=[("signature-03", "my gwo", 0)])
    dots, boxes = table(results, "amplitude-dots"), table(results, "amplitude-boxes")
    for figure in (dots, boxes):
        assert len(figure.figure.axes) == 5
        assert len(figure.data) == len(results.frame)
        assert figure.data.groupby("problem", observed=True)["expected"].first().tolist() == [
            truth(3)["amplitude_rpm"],
            truth(4)["amplitude_rpm"],
        ]
        assert len(figure.shown) == 10
        assert {"expected amplitude", "accuracy band"} <= {line.get_label() for line in figure.figure.axes[0].lines}
    drawn = {ax.get_title(loc="left"): len(ax.lines[0].get_xdata()) for ax in dots.figure.axes}
    assert drawn == {"my alo": 12, "my goa": 12, "my da": 12, "my gwo": 11, "my cma-es": 12}


def test_fig_7_3_has_both_truths_and_the_quartiles_of_what_was_found(tmp_path):
    results = make(
        tmp_path / "s", miss={"gwo": lambda level, trial: float(trial)}, fail=[("signature-03", "my gwo", 5)]
    )
    figure = table(results, "backlash-and-amplitude")
    assert len(figure.figure.axes) == 2
    assert len(figure.data) == 2 * 2 * 5
    cell = figure.data.set_index(["figure", "problem", "optimizer"]).loc["amplitude_rpm", "signature-03", "my gwo"]
    expected = truth(3)["amplitude_rpm"]
    assert cell[["expected", "q1", "median", "q3"]].tolist() == pytest.approx(expected + np.array([0, 1, 2, 3]))
    assert cell[["tolerance", "trials", "found"]].tolist() == pytest.approx([TOLERANCE_RPM, 6, 5])
    assert figure.shown.loc["signature-04", "Backlash δ in 1e-6 rad"] == pytest.approx(700)
    assert figure.shown.loc["signature-03", "Amplitude |A|, my gwo"] == pytest.approx(expected + 2)


def test_the_smallest_step_is_taken_between_neighbouring_datasets_alone(usual):
    def said(*rows):
        table = [(p, f, value, 1.0) for p, *pair in rows for f, value in zip(levels.SHOWN, pair, strict=True)]
        return levels.smallest_step(pd.DataFrame(table, columns=["problem", "figure", "expected", "tolerance"]))

    assert (
        "at least 4.0000 rpm (6.0000 rpm at most)" in said(("b", 7e-4, 16.0), ("a", 5e-4, 10.0), ("c", 9e-4, 20.0))[0]
    )
    assert said(("a", 5e-4, 10.0), ("c", 9e-4, 20.0)) == ()
    assert "smallest step is 3.8672 rpm" in words(usual, levels)


def test_the_simulated_datasets_have_steps_like_the_thesis_s():
    steps = np.diff([truth(level)["amplitude_rpm"] for level in range(3, 21)])
    assert steps.min() == pytest.approx(2 * TOLERANCE_RPM, rel=0.05)


def test_data_that_changed_is_said_and_left_out(tmp_path):
    make(tmp_path / "s")
    change_data(tmp_path / "s", {"signature-03": "of other data"})
    results = Results(tmp_path / "s")
    (warning,) = views(results, levels)[0].warnings
    assert warning.startswith("The expected values of signature-03 are not known here and left out: the data of")
    assert table(results, "backlash-and-amplitude").shown.index.tolist() == ["signature-04"]
    assert table(results, "amplitude-errors").frame["trials"].tolist() == [6] * 5
    data = table(results, "amplitude-dots").data
    assert data.groupby("problem", observed=True)["expected"].count().tolist() == [0, 30]


def recorded(folder, level=5):
    """Write a study on a user's own recording, of which no truth is known."""
    problem = load_problem(f"signature-{level:02d}")
    speed = pd.DataFrame({"time_s": problem.time, "speed_rps": problem.signal + 100})
    folder.mkdir()
    speed.to_csv(folder / "own.csv", index=False)
    study = Study("mine", (Entry(f"recording:{folder / 'own.csv'}", "a$b 日本"),), (Entry("gwo", "gwo"),), trials=1)
    return write(folder / "s", study, lambda _: ended(1.0, metrics={"amplitude_rpm": 5.0, "backlash_rad": np.nan}))


def test_without_a_truth_there_are_figures_of_the_amplitude_but_no_errors(tmp_path):
    results = recorded(tmp_path / "r")
    items = [item.name for section in views(results) for item in section.items]
    fits = ["reference-fit-by-optimizer", "reference-fit-found", "reference-fit"]
    assert items == [*fits, "amplitude-dots", "amplitude-boxes"]
    assert "No expected amplitude is known" in words(results)
    assert not any(section.warnings for section in views(results))


def test_a_study_of_other_problems_gets_nothing(tmp_path):
    study = Study("other", (Entry("p", "p"),), (Entry("gwo", "gwo"),), trials=1)
    assert sections(Findings(write(tmp_path / "s", study, lambda _: FAILED))) == []


def test_only_problems_with_the_figure_are_estimated():
    frame = pd.DataFrame(
        {
            "problem": pd.Categorical(["a", "b", "b", "c"], categories=["c", "b", "a"]),
            "optimizer": pd.Categorical(["o"] * 4), "trial": [0, 0, 1, 0], "status": ["ok", "ok", "failed", "failed"],
            "amplitude_rpm": [None, 5.0, None, None],
        }
    )  # fmt: skip
    truths = pd.DataFrame([("b", "amplitude_rpm", 6.0, 1.0)], columns=["problem", "figure", "expected", "tolerance"])
    data = accuracy.estimates(frame, truths, "amplitude_rpm")
    assert list(data["problem"].cat.categories) == ["b"]
    assert data["error"].tolist() == pytest.approx([-1.0, np.nan], nan_ok=True)
    assert data["within"].tolist() == [True, False]


def test_conclusions_that_hold_are_told_from_those_that_do_not(tmp_path):
    def amplitude(hits):  # hits of 30 trials lie within the band
        return lambda level, trial: 0.5 if trial < hits else -5.0

    hits = {"cma-es": 30, "gwo": 20, "alo": 12, "goa": 8, "da": 1}
    agreeing = {name: amplitude(number) for name, number in hits.items()}
    said = words(make(tmp_path / "a", miss=agreeing, trials=30), amplitudes)
    assert "GWO the best of the swarms and DA the least effective, and these shares agree" in said
    said = words(make(tmp_path / "b", miss=agreeing | {"goa": amplitude(28)}, trials=30), amplitudes)
    assert "DA the least effective, and these shares agree" in said
    assert "it also finds GWO the best of the swarms, and these shares disagree" in said
    assert "CMA-ES the most suited, and these shares are too close to decide" in said
    said = words(make(tmp_path / "c", miss=agreeing, trials=1), amplitudes)
    assert "these shares are too close to decide" in said
    assert "these shares agree" not in said


def test_underestimates_and_widths_are_counted(tmp_path):
    miss = {
        "alo": lambda level, trial: -1.0 - level * trial,  # always below, the wider the larger
        "goa": lambda level, trial: 1.0 + trial / level,  # never below, the narrower the larger
        "da": lambda level, trial: (-1.0 if trial % 2 else 1.0) * 9 / level,  # as often below as above
        "gwo": lambda level, trial: -1.0 + 0.001 * level * trial,
        "cma-es": lambda level, trial: trial / level,
    }  # fmt: skip
    said = words(make(tmp_path / "s", datasets=(3, 4, 5, 6, 7), miss=miss), amplitudes)
    assert "amplitude is 100% for my alo, 0% for my goa, 50% for my da and 100% for my gwo." in said
    assert "The median is below it on more than half of the datasets for 2 of 4 swarms (sign test over datasets" in said
    assert "grows with the expected amplitude for 2 of 5 optimizers" in said
    assert "my gwo had the narrowest interquartile range of the swarms on 5 of 5 problems" in said


def test_no_rank_correlation_from_three_datasets(tmp_path):
    assert "rank correlation" not in words(make(tmp_path / "s", datasets=(3, 4, 5)), amplitudes)


@pytest.mark.sampled(1)
@pytest.mark.filterwarnings("error", "default::ResourceWarning")
@pytest.mark.parametrize(
    "change",
    [
        {"optimizers": ("gwo",), "trials": 1, "datasets": (20,)},
        {"fail": [(f"signature-{k:02d}", f"my {o}", i) for k in (3, 4) for o in ("alo", "cma-es") for i in range(6)]},
        {"optimizers": (*SWARMS, "cma-es", *(f"plug-in {i} " + "$x_" * 30 for i in range(4))), "trials": 2},
        {"datasets": range(3, 21), "trials": 2, "optimizers": ("gwo", "cma-es")},
    ],
    ids=["one trial", "failed optimizers", "many optimizers", "all datasets"],
)
def test_everything_can_be_drawn_and_written(tmp_path, change):
    with style.context():
        for section in sections(Findings(make(tmp_path / "s", **change))):
            for item in section.items:
                if isinstance(item, Table):
                    assert item.rows
                else:
                    svg, _ = save_figure(item, tmp_path, item.name)
                    assert "nan" not in svg.lower()
                    assert item.table.rows
                    assert item.figure.get_figwidth() in (style.COLUMN, style.PAGE)


def test_every_trial_failed(tmp_path):
    everything = [(f"signature-{k:02d}", f"my {o}", i) for k in (3, 4) for o in ("alo", "gwo") for i in range(6)]
    assert sections(Findings(make(tmp_path / "s", optimizers=("alo", "gwo"), fail=everything))) == []


def test_dataset_labels_are_numbers_or_upright_names(tmp_path, usual):
    def ticks(results):
        figure = next(item for s in views(results) for item in s.items if item.name == "amplitude-boxes").figure
        return [(label.get_text(), label.get_rotation()) for label in figure.axes[-1].get_xticklabels()]

    assert ticks(usual) == [("3", 0), ("4", 0)]
    assert ticks(recorded(tmp_path / "r")) == [(r"a\$b 日本", 90)]


def test_the_views_come_in_the_thesis_s_order(usual):
    assert [
        (section.title, [item.name for item in section.items if isinstance(item, Figure)]) for section in views(usual)
    ] == [
        ("Backlash and amplitude of the datasets (thesis Fig. 7.3)", ["backlash-and-amplitude"]),
        ("Fitting error (thesis Table 7.2)", []),
        ("Reference fit", []),
        ("Disturbance amplitude (thesis Fig. 7.4)", ["amplitude-dots", "amplitude-boxes"]),
    ]
