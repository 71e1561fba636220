"""The runner and the store: nothing is lost, and nothing depends on how the work was done."""

import json
import os

import numpy as np
import pandas as pd
import pytest

from bench import BenchError, Results, Study, load_results, run, solve
from bench.execution.runner import plan
from bench.storage import provenance
from bench.storage.folder import Folder
from bench.storage.under_way import noting
from bench.study import Entry

TIMES = ["wall_s", "cpu_s", "objective_s", "memory_mb"]


def same(a, b):
    pd.testing.assert_frame_equal(a.drop(columns=TIMES), b.drop(columns=TIMES), check_exact=True)


@pytest.fixture(scope="module")
def made(small_study, tmp_path_factory):
    """What a run returns, whose folder no test changes."""
    return run(small_study, tmp_path_factory.mktemp("made") / "out", n_jobs=1)


def test_a_run_fills_the_frame(made):
    assert (made.made, made.failed) == (18, 0)
    frame = load_results(made.folder)
    assert len(frame) == 18
    assert frame["problem"].unique().tolist() == ["sphere-2", "sphere-3"]
    assert frame["optimizer"].unique().tolist() == ["hill-climber", "scatter", "early"]
    assert frame["status"].eq("ok").all()
    by_optimizer = frame.groupby("optimizer")
    assert by_optimizer["nfev"].unique().map(list).to_dict() == {"early": [5], "hill-climber": [60], "scatter": [60]}
    assert by_optimizer["stop"].unique().map(list).to_dict() == {
        "early": ["tired"], "hill-climber": ["budget"], "scatter": ["budget"]
    }  # fmt: skip
    assert frame["seed"].is_unique
    points = frame[["x_x1", "x_x2", "x_x3"]].fillna(0.0)
    np.testing.assert_allclose((points**2).sum(axis=1), frame["fun"], rtol=1e-15)
    np.testing.assert_allclose(frame["radius"] ** 2, frame["fun"], rtol=1e-15)
    assert (frame["objective_s"] <= frame["wall_s"]).all()


def test_a_row_s_seed_repeats_its_trial(small_study, made):
    results = Results(made.folder)
    row = results.frame[results.frame["optimizer"] == "scatter"].iloc[0]
    again = solve(results.problem(row["problem"]), small_study.optimizer("scatter"), budget=60, seed=int(row["seed"]))
    assert again.fun == row["fun"]
    stored = results.traces[row["problem"], "scatter", row["trial"]]
    assert stored.values.tolist() == again.trace.values.tolist()
    assert stored.evaluations.tolist() == again.trace.evaluations.tolist()


def test_workers_and_other_optimizers_change_no_result(small_study, made, tmp_path):
    run(small_study, tmp_path / "two", n_jobs=2)
    same(load_results(made.folder), load_results(tmp_path / "two"))
    alone = Study.from_dict(
        {"name": "small", "trials": 3, "budget": 60, "seed": 5, "problems": [{"name": "sphere-3"}],
         "optimizers": [{"name": "scatter", "agents": 7}]}
    )  # fmt: skip
    run(alone, tmp_path / "alone", n_jobs=1)
    all_of_it = load_results(made.folder)
    part = all_of_it[(all_of_it["optimizer"] == "scatter") & (all_of_it["problem"] == "sphere-3")]
    same(part.reset_index(drop=True), load_results(tmp_path / "alone"))


def test_a_rerun_makes_nothing_and_more_trials_extend(small_study, made, tmp_path):
    run(small_study.override(trials=2), tmp_path / "out", n_jobs=1)
    assert run(small_study.override(trials=2), tmp_path / "out", n_jobs=1).made == 0
    assert run(small_study, tmp_path / "out", n_jobs=1).made == 6
    same(load_results(tmp_path / "out"), load_results(made.folder))


def test_a_folder_that_no_run_wrote_is_refused(small_study, tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.docx").write_text("my life's work")
    with pytest.raises(BenchError, match="is not empty and holds no study"):
        run(small_study, tmp_path / "full", n_jobs=1)
    (tmp_path / "file").write_text("")
    with pytest.raises(BenchError, match="cannot be written"):
        run(small_study, tmp_path / "file", n_jobs=1)
    holder = {"pid": os.getpid(), "host": provenance.host(), "started": provenance.now()}
    with noting(tmp_path / "full", holder), pytest.raises(BenchError, match="another run"):
        run(small_study, tmp_path / "full", n_jobs=1)  # its study is not there yet


def test_a_failing_trial_costs_its_own_cell(small_study, tmp_path):
    study = Study.from_dict(
        {"name": "faults", "trials": 2, "budget": 30, "problems": [{"names": ["sphere-2", "sphere-3"]}],
         "optimizers": [{"name": "faulty"}, {"name": "scatter"}]}
    )  # fmt: skip
    outcome = run(study, tmp_path / "out", n_jobs=1)
    assert outcome.failed == 2
    frame = load_results(tmp_path / "out")
    failed = frame[frame["status"] == "failed"]
    assert set(zip(failed["problem"], failed["optimizer"], strict=True)) == {("sphere-2", "faulty")}
    assert failed["error"].str.startswith("RuntimeError: cannot do planes").all()
    assert failed["fun"].isna().all()
    assert len(frame) == 8
    assert run(study, tmp_path / "out", n_jobs=1).made == 2  # failed trials are tried again


def test_solve_by_name_and_stop_reasons():
    assert solve("sphere-3", "early", budget=50).stop == "tired"
    from bench import load_optimizer

    assert solve("sphere-3", load_optimizer("early", honest=False), budget=50).stop == "undeclared"
    assert solve("sphere-3", load_optimizer("early", honest=False), budget=5).stop == "budget"
    result = solve("sphere-3", "hill-climber", budget=2000, seed=1)
    assert result.fun < 1e-6
    assert result.cost.overhead_s > 0


@pytest.mark.slow
def test_a_store_whose_table_was_never_made_is_refused_where_trials_were_committed(small_study, tmp_path):
    """A kill between the file's creation and its table's leaves an empty store."""
    run(small_study.override(trials=1), tmp_path / "out", n_jobs=1)
    for file in (tmp_path / "out").glob("trials.sqlite*"):
        file.unlink()
    (tmp_path / "out" / "trials.sqlite").touch()
    with pytest.raises(BenchError, match="6 of 6 committed trials are missing; restore"):
        load_results(tmp_path / "out")
    with pytest.raises(BenchError, match="6 of 6 committed trials are missing; restore"):
        run(small_study.override(trials=1), tmp_path / "out", n_jobs=1)
    (tmp_path / "out" / "committed.json").unlink()
    assert run(small_study.override(trials=1), tmp_path / "out", n_jobs=1).made == 6


@pytest.mark.parametrize("file", ["verification.json", "checks.json", "study.toml"])
@pytest.mark.parametrize("content", ['{"sphere-2": "f0', "[]", "\xff"])
def test_a_damaged_file_of_a_folder_is_never_passed_over(small_study, file, content, tmp_path):
    folder = Folder(tmp_path)
    folder.claim(small_study)
    (tmp_path / file).write_text(content, encoding="latin-1")
    uses = {
        "verification.json": lambda: folder.noted(file), "checks.json": folder.checks,
        "study.toml": folder.study,
    }  # fmt: skip
    with pytest.raises(BenchError) as caught:
        uses[file]()
    assert str(tmp_path / file) in str(caught.value)
    assert (tmp_path / file).read_text(encoding="latin-1") == content
    assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_the_copy_of_the_environments_is_written_anew(small_study, tmp_path):
    run(small_study.override(trials=1), tmp_path, n_jobs=1)
    (tmp_path / "environment.json").write_text("{")
    run(small_study, tmp_path, n_jobs=1)
    assert json.loads((tmp_path / "environment.json").read_text()) == Folder(tmp_path).environments()


ODD = {
    "names-3": "names 2 different variables for 3 dimensions", "figures-2": "a name of the tidy frame: 'fun'",
    "text-2": "could not convert", "exit-2": "SystemExit", "minus-2": "returned -inf",
}  # fmt: skip


def test_each_problem_that_breaks_the_contract_costs_its_own_cell(tmp_path):
    study = Study.from_dict(
        {"name": "odd", "trials": 1, "budget": 30, "problems": [{"names": [*ODD, "sphere-2"]}],
         "optimizers": [{"name": "scatter"}]}
    )  # fmt: skip
    assert run(study, tmp_path / "out", n_jobs=1).failed == len(ODD)
    frame = load_results(tmp_path / "out").set_index("problem")
    assert frame["status"].to_dict() == dict.fromkeys(ODD, "failed") | {"sphere-2": "ok"}
    for problem, said in ODD.items():
        assert said in frame.loc[problem, "error"]
        assert frame.loc[problem, "error"].startswith("ProblemError: ")


def test_a_problem_that_ends_its_process_costs_its_own_cell(tmp_path):
    study = Study.from_dict(
        {"name": "dying", "trials": 3, "budget": 30, "problems": [{"name": "sphere-2"}, {"name": "death-2"}],
         "optimizers": [{"name": "scatter"}]}
    )  # fmt: skip
    assert run(study, tmp_path / "out", n_jobs=1).failed == 3
    frame = load_results(tmp_path / "out")
    assert frame.groupby("problem")["status"].unique().map(list).to_dict() == {
        "death-2": ["failed"],
        "sphere-2": ["ok"],
    }
    assert frame["error"].dropna().eq("its process ended with exit code 1").all()


@pytest.mark.parametrize(
    ("code", "patience", "said"),
    [
        (
            "import time\ntime.sleep(1000)",
            0.5,
            "takes more than 0.5 s; try each with .bench solve.",
        ),
        ("import os\nos._exit(3)", 600.0, "failed: exit code 3"),
        ("raise SystemExit(4)", 600.0, "SystemExit"),
        ("def f(:", 600.0, "invalid syntax"),
    ],
)
@pytest.mark.sampled(2)
def test_a_plug_in_that_cannot_be_loaded_ends_the_run_before_it_begins(code, patience, said, tmp_path, monkeypatch):
    monkeypatch.setattr("bench.execution.supervisor.LOADING", patience)
    (tmp_path / "mine.py").write_text(f"{code}\ndef mine(objective, rng):\n    pass\n")
    study = {"name": "s", "problems": [{"name": "sphere-2"}], "optimizers": [{"name": f"{tmp_path / 'mine.py'}:mine"}]}
    with pytest.raises(BenchError, match=said) as refused:
        run(Study.from_dict(study), tmp_path / "out", n_jobs=2)
    assert "\n" not in str(refused.value)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("of", [plan, run])
def test_targets_that_no_problem_has_are_refused_before_the_first_trial(tmp_path, of):
    study = Study("s", (Entry("sphere-2", "p"),), (Entry("scatter", "o"),), trials=1, budget=60, targets="tolerance")
    with pytest.raises(BenchError, match="targets by tolerance need a problem with an expected metric"):
        of(study, tmp_path / "s")
    assert not (tmp_path / "s").exists()


@pytest.mark.parametrize(("other", "said"), [("missing", "to be reused does not exist"), ("out", "leave it out")])
def test_what_cannot_be_reused_is_refused_before_anything_is_written(other, said, small_study, tmp_path):
    with pytest.raises(BenchError, match=said):
        run(small_study, tmp_path / "out", reuse=[tmp_path / other])
    assert not (tmp_path / "out").exists()
