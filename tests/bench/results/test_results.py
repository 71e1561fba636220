"""Reading one folder, and several beside each other."""

from dataclasses import replace

import pandas as pd
import pytest

from bench import BenchError, Results, Study, load_results, run
from bench.storage.folder import Folder
from bench.study import Entry
from tests.bench.formats.made import make, some_fail
from tests.bench.storage.filled import TRIALS, change_data


@pytest.fixture
def ran(tmp_path, small_study):
    """Run variants of the small study into folders, by name."""

    def make(name, **changes):
        optimizers = changes.pop("optimizers", None)
        study = small_study.override(**changes)
        if optimizers:
            study = Study.from_dict({**_as_dict(study), "optimizers": optimizers})
        run(study, tmp_path / name, n_jobs=1)
        return tmp_path / name

    return make


def _as_dict(study):
    return {
        "name": study.name, "trials": study.trials, "budget": study.budget, "seed": study.seed,
        "problems": [entry.as_dict() for entry in study.problems],
        "optimizers": [entry.as_dict() for entry in study.optimizers],
    }  # fmt: skip


def test_one_folder_keeps_its_labels(ran):
    results = Results(ran("one"))
    assert results.frame["optimizer"].unique().tolist() == ["hill-climber", "scatter", "early"]
    assert set(results.traces) == set(results.frame[["problem", "optimizer", "trial"]].itertuples(index=False))
    assert results.changed == {}


def test_the_frame_says_of_which_kind_each_problem_is(tmp_path, testing_plugins):
    names = ["bbob-f01-d2-i1", "sphere-3", "nobody:knows"]
    study = Study("kinds", tuple(Entry(name, name) for name in names), (Entry("early", "early"),))
    frame = Results(made_up(tmp_path / "s", study)).frame
    columns = ["suite", "function", "dimension", "instance", "group"]
    assert list(frame)[-5:] == columns
    kinds = frame.drop_duplicates("problem").set_index("problem")[columns].astype(object)
    assert kinds.loc["bbob-f01-d2-i1"].tolist() == ["bbob", "f01", 2, 1, "separable"]
    assert kinds.loc["sphere-3"].isna().tolist() == [True, True, False, True, True]
    assert kinds.loc["sphere-3", "dimension"] == 3
    assert kinds.loc["nobody:knows"].isna().all()


def made_up(path, study):
    """Write a study's folder with one trial a cell, which no optimizer made."""
    path.mkdir()
    folder = Folder(path)
    folder.claim(study)
    with folder.store.writer() as writer:
        number = writer.record("environments", {"host": "here"})
        for trial in replace(study, trials=1).plan():
            writer.add(trial, {"status": "failed", "error": "RuntimeError: no"}, number)
    return path


def test_a_selection_has_the_trials_and_traces_of_its_cells_alone(filled):
    whole = Results(filled.path)
    part = whole.select(optimizers="sc*", dimensions=3)
    here = (whole.frame["optimizer"] == "scatter") & (whole.frame["problem"] == "sphere-3")
    pd.testing.assert_frame_equal(part.frame, whole.frame[here].reset_index(drop=True), check_exact=True)
    assert set(part.traces) == {key for key in whole.traces if key[:2] == ("sphere-3", "scatter")}
    assert (part.planned, part.budgets) == ({"scatter": TRIALS}, {"scatter": 60})
    assert part.whole == whole.study
    assert "early" not in part._repr_html_()
    assert part.select(problems="*").whole == whole.study


@pytest.mark.slow
def test_two_versions_of_an_optimizer_are_distinguished_by_folder(ran):
    old, new = ran("old"), ran("new", optimizers=[{"name": "scatter", "agents": 9}, {"name": "early"}])
    results = Results(old, new)
    labels = ["hill-climber", "scatter (old)", "early (old)", "scatter (new)", "early (new)"]
    assert [entry.label for entry in results.study.optimizers] == labels
    assert results.frame.groupby("problem", sort=False)["optimizer"].unique().map(list).tolist() == [labels, labels]
    assert results.frame["trial"].tolist() == [0, 1, 2] * 10
    assert set(results.traces) == set(results.frame[["problem", "optimizer", "trial"]].itertuples(index=False))
    alone = load_results(old)
    both = results.frame[results.frame["optimizer"] == "scatter (old)"]
    pd.testing.assert_series_equal(
        both["fun"], alone.loc[alone["optimizer"] == "scatter", "fun"], check_index=False, check_exact=True
    )
    assert [record["folder"] for record in results.environments] == ["old", "new"]
    pd.testing.assert_frame_equal(load_results(old, new), results.frame)


@pytest.mark.slow
def test_folders_of_one_name_are_distinguished_by_their_parents(ran):
    results = Results(ran("a/out"), ran("b/out"))
    assert [entry.label for entry in results.study.optimizers][::3] == ["hill-climber (a/out)", "hill-climber (b/out)"]


def test_what_cannot_be_compared_is_refused(ran):
    one = ran("one")
    with pytest.raises(BenchError, match=r"the budget 60, and .small. 50"):
        Results(one, ran("short", budget=50))
    with pytest.raises(BenchError, match="given twice"):
        Results(one, one)
    other = ran("data")
    change_data(other, {"sphere-2": "f00"})
    change_data(one, {"sphere-2": "ba7"})
    with pytest.raises(BenchError, match="other data"):
        Results(one, other)


@pytest.mark.slow
def test_a_problem_whose_options_differ_is_refused(ran):
    one, two = ran("one"), ran("two")
    study = Folder(two).study()
    shifted = tuple(replace(entry, options={"shift": 1}) for entry in study.problems)
    Folder(two).claim(replace(study, problems=shifted))
    with pytest.raises(BenchError, match="problem 'sphere-2' has other options"):
        Results(one, two)


def test_a_problem_whose_data_changed_is_not_loaded(ran):
    folder = ran("one")
    assert Results(folder).problem("sphere-2").dimension == 2
    change_data(folder, {"sphere-2": "f00"})
    with pytest.raises(BenchError, match="no longer what the trials were made with"):
        Results(folder).problem("sphere-2")


@pytest.mark.slow
def test_labels_that_look_alike_with_their_folder_stay_apart(ran):
    old = ran("old", optimizers=[{"name": "early"}, {"name": "scatter", "label": "early (old)"}])
    labels = [entry.label for entry in Results(old, ran("new", optimizers=[{"name": "early"}])).study.optimizers]
    assert labels == ["early (old)", "early (old)-2", "early (new)"]


class TestPrecision:
    @pytest.fixture
    def mixed(self, tmp_path):
        pytest.importorskip("cocoex", reason="the optimal values of bbob come from coco-experiment")
        problems = {"bbob-f01-d2-i1": 2, "bbob-f01-d2-i2": 2, "sphere-2": 2}
        return make(tmp_path / "s", problems, row=some_fail)

    def test_it_is_the_value_less_the_optimum_of_a_suite_s_problem(self, mixed):
        frame = mixed.frame
        assert list(frame)[list(frame).index("fun") + 1] == "precision"
        optima = frame["problem"].map({f"bbob-f01-d2-i{i}": mixed.facts(f"bbob-f01-d2-i{i}").optimum for i in (1, 2)})
        pd.testing.assert_series_equal(frame["precision"], frame["fun"] - optima, check_names=False, check_exact=True)
        assert frame.loc[frame["problem"] == "sphere-2", "precision"].isna().all()

    def test_a_frame_without_a_known_optimum_has_no_such_column(self, tmp_path):
        assert "precision" not in make(tmp_path / "s", {"sphere-2": 2}).frame


@pytest.mark.slow
def test_the_facts_hold_the_optimum_of_repaired_points_where_it_is_another_one(tmp_path):
    entries = [Entry("signature-03", "free"), Entry("signature-03", "bound", {"constrained": True})]
    Folder(tmp_path).claim(Study("s", tuple(entries), (Entry("gwo", "gwo"),)))
    free, bound = map(Results(tmp_path).facts, ("free", "bound"))
    assert free.repaired_optimum > 1.001 * free.optimum
    assert bound.repaired_optimum is None
    assert bound.optimum == free.repaired_optimum
