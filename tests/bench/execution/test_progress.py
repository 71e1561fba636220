"""The progress of a run from Python: printed where it is asked for or in a notebook, and silent in a script."""

import pytest

from bench import Study, run
from bench.execution import progress


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("asked", "notebook", "shown"), [(None, False, 0), (None, True, 1), (True, False, 1), (False, True, 0)]
)
def test_a_run_prints_its_progress_where_it_is_asked_for_and_in_a_notebook(
    asked, notebook, shown, small_study, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(progress, "in_notebook", lambda: notebook)
    heard = []
    study = small_study.override(trials=1)
    run(
        study,
        tmp_path / "out",
        n_jobs=1,
        progress=asked,
        on_plan=heard.append,
        on_trial=lambda *each: heard.append(each),
    )
    printed = capsys.readouterr().out
    assert printed.count("study small: 2 problems x 3 optimizers x 1 trial = 6 runs of 60 evaluations") == shown
    assert printed.count("6 of 6 runs done") == shown
    assert len(heard) == 7
    assert heard[0].folder == tmp_path / "out"


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
