"""A run with declared looks: it stops decided cells, makes the same trials, and continues in the same state."""

import json
import shutil

import pandas as pd
import pytest

from bench import BenchError, Study, load_results, run
from bench.execution.looks import stopped_cells
from bench.execution.runner import plan
from bench.storage.folder import Folder
from bench.storage.merge import merge

TIMES = ["wall_s", "cpu_s", "objective_s"]
FAR = ("sphere-2", "hill-climber")
LOOKED = {
    "name": "looked", "budget": 150, "seed": 5, "looks": {"trials": [12, 16]},
    "problems": [{"names": ["sphere-2", "sphere-3"]}],
    "optimizers": [{"name": "scatter", "agents": 7}, {"name": "scatter", "agents": 8, "label": "other"},
                   {"name": "hill-climber"}],
}  # fmt: skip


@pytest.fixture(scope="module")
def looked():
    """Two equal optimizers, and one that is far better on both problems."""
    return Study.from_dict(LOOKED)


@pytest.fixture(scope="module")
def whole(looked, tmp_path_factory):
    """A finished run and what it called after each look; no test changes the folder."""
    seen = []
    path = tmp_path_factory.mktemp("whole") / "out"
    outcome = run(looked, path, jobs=1, on_look=lambda look, plan: seen.append((look, dict(plan.stopped))))
    return path, outcome, seen


def rows(path):
    return load_results(path).drop(columns=TIMES).set_index(["problem", "optimizer", "trial"]).sort_index()


@pytest.mark.slow
def test_decided_cells_get_no_more_trials_and_all_others_are_as_without_looks(looked, whole, tmp_path):
    path, outcome, seen = whole
    found = rows(path)
    sizes = found.groupby(level=["problem", "optimizer"]).size()
    assert sizes[FAR] == 12
    assert set(sizes) == {12, 16}
    assert outcome.made == sizes.sum() < 96
    assert [look for look, _ in seen] == [12, 16]
    assert {cell for cell, end in seen[-1][1].items() if end == 12} == set(sizes[sizes == 12].index)
    assert seen[-1][1] == stopped_cells(looked, Folder(path).store)
    plain = Study.from_dict({key: value for key, value in LOOKED.items() if key != "looks"} | {"trials": 16})
    run(plain, tmp_path / "plain", jobs=1)
    pd.testing.assert_frame_equal(found, rows(tmp_path / "plain").loc[found.index])
    record = json.loads((path / "environment.json").read_text())
    assert [(each["trials"], each["extends"]) for each in record] == [(16, None)]  # one run, whatever its looks


@pytest.mark.slow
@pytest.mark.parametrize("after", [75])  # between the looks
def test_an_interrupted_run_continues_in_the_same_state(looked, whole, tmp_path, after):
    made = []

    def interrupt(trial, row):
        made.append(trial)
        if len(made) == after:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(looked, tmp_path / "out", jobs=1, on_trial=interrupt)
    assert len(load_results(tmp_path / "out")) == after
    rest = run(looked, tmp_path / "out", jobs=2)
    pd.testing.assert_frame_equal(rows(tmp_path / "out"), rows(whole[0]))
    assert rest.made == len(rows(whole[0])) - after
    record = json.loads((tmp_path / "out" / "environment.json").read_text())
    assert {each["extends"] for each in record} == {None}


def test_a_finished_run_makes_nothing_more(looked, whole, tmp_path):
    shutil.copytree(whole[0], tmp_path / "copy")
    assert run(looked, tmp_path / "copy", jobs=1).made == 0


def test_the_plan_knows_what_is_stopped_and_what_may_come(looked, whole, tmp_path):
    assert set(plan(looked, tmp_path / "out").counts().values()) == {(16, 0)}
    after = plan(looked, whole[0])
    assert next(after.missing(), None) is None
    assert after.counts()[FAR] == (12, 12)
    assert after.most(*FAR) == 12
    assert list(after.missing(12)) == []


def test_a_blind_look_is_announced(looked, tmp_path):
    noted = plan(looked.override(looks=[8, 40], trials=40), tmp_path / "out").notes
    assert noted == ["so little of the level is spent by the look at 8 of 40 trials that nothing can be decided there"]
    assert plan(looked, tmp_path / "out").notes == []


def test_looks_are_declared_before_the_first_trial(looked, whole, small_study, tmp_path):
    run(small_study, tmp_path / "plain", jobs=1)
    with pytest.raises(BenchError, match="was begun without looks: looks are declared before the first trial"):
        plan(small_study.override(looks=[6, 8], trials=8), tmp_path / "plain")
    for other, begun in (((12, 20), 20), ((12, 14, 16), 16)):
        with pytest.raises(BenchError, match="was begun with looks at 12, 16 trials"):
            plan(looked.override(looks=other, trials=begun), whole[0])
    with pytest.raises(BenchError, match=r"16 trials of another study, or of other code: looks are declared"):
        plan(looked.override(budget=61), whole[0])


def test_shards_are_refused_and_folders_merge(looked, whole, tmp_path):
    with pytest.raises(BenchError, match=r"declares looks, .* leave out --shard"):
        run(looked, tmp_path / "part", shard="1/2")
    assert not (tmp_path / "part").exists()
    merge([whole[0]], tmp_path / "merged")
    assert stopped_cells(looked, Folder(tmp_path / "merged").store) == whole[2][-1][1]


@pytest.mark.slow
def test_more_trials_after_complete_ones_are_on_record(small_study, tmp_path):
    def recorded():
        run_records = json.loads((tmp_path / "out" / "environment.json").read_text())
        return [(each["trials"], each["extends"]) for each in run_records]

    def interrupt(trial, row):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(small_study, tmp_path / "out", jobs=1, on_trial=interrupt)
    run(small_study.override(trials=4), tmp_path / "out", jobs=1)  # trials that were not complete: no extension
    assert recorded() == [(3, None), (4, None)]
    with pytest.raises(KeyboardInterrupt):
        run(small_study.override(trials=6), tmp_path / "out", jobs=1, on_trial=interrupt)
    run(small_study.override(trials=6), tmp_path / "out", jobs=1)  # continues, and extends nothing
    assert recorded()[2:] == [(6, 4), (6, None)]
    run(small_study.override(trials=2), tmp_path / "out", jobs=1)
    assert len(recorded()) == 4
