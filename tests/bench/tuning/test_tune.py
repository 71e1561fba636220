"""Tuning: the defaults first, the same end after an interruption and with any number of jobs, failures worst."""

from dataclasses import replace

import numpy as np
import pytest
from filelock import FileLock

from bench import BenchError, solve
from bench.plugins import loading
from bench.seeds import trial_seed
from bench.study.budget import Budget
from bench.tuning.tune import TuningRun, TuningSetup, _outcome, score, spaces, tune

SETTING = TuningSetup("regret", 8, 2, Budget.read(60), 3, ("sphere-2", "sphere-3"), {})


def tuned(folder, setting=SETTING, optimizers=("scatter",), jobs=1):
    axes = spaces(optimizers, setting.fixed, 60, ["agents"])
    problems = {name: loading.load_problem(name) for name in setting.train}
    return tune(axes, problems, setting, folder / "t.journal", jobs)


def timeless(best):
    return replace(best, record=replace(best.record, seconds=0.0))


@pytest.fixture(scope="module")
def whole(tmp_path_factory, testing_plugins):
    (best,) = tuned(tmp_path_factory.mktemp("whole"))
    return best


def test_the_defaults_are_the_first_configuration_and_the_record_is_complete(whole):
    record = whole.record
    assert record.values["agents"][0] == 10
    assert len(record.scores) == len(record.problems) == 8
    assert record.evaluations == sum(2 * 60 * number for number in record.problems)
    assert record.failed == 0
    assert record.best == min(score for score, all_of in zip(record.scores, record.whole, strict=True) if all_of)
    assert (record.tuned == "scatter-tuned") == bool(whole.options)
    if whole.options:
        assert whole.options == {"agents": record.values["agents"][record.scores.index(record.best)]}


def test_a_training_problem_that_raises_ends_the_tuning_and_is_blamed(tmp_path):
    said = "^the training problem minus-2 failed, which judges no configuration: .*; mend it, or leave it out$"
    with pytest.raises(BenchError, match=said) as raised:
        tuned(tmp_path, replace(SETTING, train=("sphere-2", "minus-2"), trials=1))
    assert "scatter" not in str(raised.value)


def test_a_score_is_that_of_runs_of_its_own(whole):
    regrets = [
        np.median([
            solve(name, "scatter", budget=60, seed=trial_seed(3, name, "scatter", run)).fun for run in range(2)
        ])
        for name in SETTING.train
    ]  # fmt: skip
    assert whole.record.scores[0] == pytest.approx(np.log10(regrets).mean())


def test_an_interrupted_tuning_goes_on_to_the_same_end(whole, tmp_path, monkeypatch):
    from bench.tuning import tune as module

    tuned(tmp_path, replace(SETTING, trials=3))
    outcomes = iter([1, 1, 0])

    def interrupt(future):
        if not next(outcomes):
            raise KeyboardInterrupt
        return _outcome(future)

    monkeypatch.setattr(module, "_outcome", interrupt)
    with pytest.raises(KeyboardInterrupt):
        tuned(tmp_path)
    monkeypatch.undo()
    (again,) = tuned(tmp_path, jobs=2)
    assert timeless(again) == timeless(whole)
    (fewer,) = tuned(tmp_path, replace(SETTING, trials=3))
    assert fewer.record.scores == whole.record.scores[:3]


def test_another_tuning_is_not_continued(tmp_path):
    tuned(tmp_path, replace(SETTING, trials=1))
    for changes, named in (
        ({"seed": 9}, "seed"),
        ({"runs": 3}, "number of runs"),
        ({"objective": "aocc"}, "objective"),
    ):
        with pytest.raises(BenchError, match=f"the tuning of 'scatter' was begun with another {named}"):
            tuned(tmp_path, replace(SETTING, trials=1, **changes))
    (tmp_path / "t.journal").write_text("{]\n{]\n")
    with pytest.raises(BenchError, match="is damaged; remove it to begin again"):
        tuned(tmp_path)


def test_two_tunings_do_not_share_a_journal(tmp_path):
    with FileLock(tmp_path / ".t.journal.lock"), pytest.raises(BenchError, match="another tuning is writing to"):
        tuned(tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(BenchError, match="cannot be written"):
        tuned(tmp_path / "file")


def test_a_tuning_killed_before_its_first_run_begins_again(whole, tmp_path):
    import optuna

    file = str(tmp_path / "t.journal")
    backend = optuna.storages.journal
    storage = optuna.storages.JournalStorage(
        backend.JournalFileBackend(file, lock_obj=backend.JournalFileOpenLock(file))
    )
    optuna.create_study(storage=storage, study_name="scatter").enqueue_trial({"agents": 10})
    (again,) = tuned(tmp_path)
    assert timeless(again) == timeless(whole)


def test_failed_runs_score_worst_and_lose_nothing_else(tmp_path):
    (best,) = tuned(tmp_path, replace(SETTING, trials=2, runs=1, train=("death-2", "sphere-2")))
    assert best.record.failed == 2
    assert not best.options or best.record.best < best.record.scores[0]
    assert best.record.scores[0] > 49  # the mean of log10 of 1e100 and a finite one
    hanging = replace(SETTING, trials=1, runs=1, train=("slow-2",), timeout=0.001)
    (tmp_path / "b").mkdir()
    assert tuned(tmp_path / "b", hanging)[0].record.failed == 1


def test_regrets_are_medians_and_failed_runs_the_worst():
    runs = [TuningRun(5.001), TuningRun(5.0), TuningRun(error="lost")]
    assert score(runs, "regret", 5.0, 60) == pytest.approx(-3)
    assert score(runs[1:2], "regret", 5.0, 60) == pytest.approx(-8)
    assert score(runs[2:], "regret", 5.0, 60) == pytest.approx(100)
    assert score(runs[2:], "aocc", 5.0, 60) == 1


def test_the_area_is_that_of_the_definition():
    trace = solve("sphere-2", loading.load_optimizer("scatter", agents=6), budget=60, seed=5).trace
    curve = [trace.values[trace.evaluations <= evaluation].min() for evaluation in range(1, 61)]
    area = np.mean([1 - (np.clip(np.log10(value), -8, 2) + 8) / 10 for value in curve])
    runs = [TuningRun(1.0, trace=trace), TuningRun(error="lost")]
    assert score(runs, "aocc", 0.0, 60) == pytest.approx(1 - area / 2)


def test_a_worse_configuration_is_stopped_early(tmp_path):
    known = [f"bbob-f01-d2-i{instance}" for instance in range(1, 7)]
    fixed = {"handling": "box", "variant": "code"}
    setting = replace(SETTING, trials=12, runs=1, budget=Budget.read(300), train=tuple(known), fixed=fixed)
    problems = {name: loading.load_problem(name) for name in known}
    (best,) = tune(spaces(["gwo"], fixed, 300, ["agents"]), problems, setting, tmp_path / "t.journal", 1)
    stopped = [number for number, all_of in zip(best.record.problems, best.record.whole, strict=True) if not all_of]
    assert stopped
    assert min(stopped) >= 4  # fewer pairs cannot reach p < 0.1
