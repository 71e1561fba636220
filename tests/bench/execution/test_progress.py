"""The progress of a run from Python: printed where it is asked for or in a notebook, and silent in a script."""

import pytest

from bench import BenchError, Listener, Study, run
from bench.execution.progress import Display, listening


def test_a_run_prints_its_progress_where_it_is_asked_for(small_study, tmp_path, capsys):
    run(small_study.override(trials=1), tmp_path / "out", n_jobs=1, progress=True)
    printed = capsys.readouterr().out
    assert printed.count("study small: 2 problems x 3 optimizers x 1 trial = 6 runs of 60 evaluations") == 1
    assert printed.count("6 of 6 runs done") == 1


def test_a_listener_hears_the_plan_and_then_every_trial(small_study, tmp_path, capsys):
    heard = []

    class Ears(Listener):
        def plan(self, plan):
            heard.append(plan.folder)

        def trial(self, trial, row):
            heard.append(row["status"])

    run(small_study.override(trials=1), tmp_path / "out", n_jobs=1, progress=Ears())
    assert heard == [tmp_path / "out", *["ok"] * 6]
    with pytest.raises(BenchError, match=r"progress must be true, false or a bench\.Listener, not <built-in"):
        run(small_study, tmp_path / "none", progress=print)
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("asked", "notebook", "shown"),
    [(None, False, False), (None, True, True), (True, False, True), (False, True, False)],
)
def test_progress_is_displayed_in_a_notebook_and_where_it_is_asked_for(asked, notebook, shown, monkeypatch):
    if notebook:  # rich asks a kernel's process so
        kernel = type("ZMQInteractiveShell", (), {})
        monkeypatch.setattr("builtins.get_ipython", kernel, raising=False)
    assert isinstance(listening(asked), Display) is shown


def test_a_part_of_a_study_may_hold_no_trial(small_study, tmp_path, capsys):
    assert run(small_study, tmp_path / "out", n_jobs=1, shard="900/900", progress=True).made == 0
    assert "; shard 900/900 of them: 0 runs" in capsys.readouterr().out


def test_a_plan_says_how_many_problems_a_report_makes_of_instances(tmp_path, capsys):
    problems = [{"suite": "classical", "functions": ["sphere"], "dimensions": [2, 3], "instances": "1-2"}]
    study = Study.from_dict(
        {"name": "s", "trials": 1, "budget": 30, "problems": problems, "optimizers": ["random-search"]}
    )
    run(study, tmp_path / "out", n_jobs=1, verify=0, progress=True)
    said = "study s: 4 problems (2 with instances pooled) x 1 optimizer x 1 trial = 4 runs of 30 evaluations"
    assert said in capsys.readouterr().out
