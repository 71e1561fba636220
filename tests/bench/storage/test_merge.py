"""Shards, merging and verifying: what many machines make is one study, the same bit by bit."""

import shutil

import pandas as pd
import pytest

from bench import BenchError, Results, Study, load_results, run
from bench.execution.verify import verify
from bench.storage.merge import merge
from bench.storage.store import Store
from tests.bench.storage.changes import SCATTER, change, forge
from tests.bench.storage.filled import change_data

TIMES = ["wall_s", "cpu_s", "objective_s", "memory_mb"]


def same(a, b):
    a, b = Results(a), Results(b)
    pd.testing.assert_frame_equal(a.frame.drop(columns=TIMES), b.frame.drop(columns=TIMES), check_exact=True)
    assert {key: trace.values.tobytes() for key, trace in a.traces.items()} == {
        key: trace.values.tobytes() for key, trace in b.traces.items()
    }


def forged(folder, what):
    forge(folder / "trials.sqlite", f"UPDATE results SET {what} WHERE trial = 1 AND cell = {SCATTER}")


@pytest.fixture(scope="module")
def whole(small_study, tmp_path_factory):
    """The study in one folder, and in three shards of it, which no test changes."""
    study, place = small_study, tmp_path_factory.mktemp("whole")
    run(study, place / "whole", n_jobs=1)
    for number in (1, 2, 3):
        run(study, place / f"shard-{number}", n_jobs=1, shard=f"{number}/3")
    return study, place


@pytest.fixture
def copied(whole, tmp_path):
    """Copies that a test may change."""
    study, place = whole
    shutil.copytree(place, tmp_path / "copies")
    return study, tmp_path / "copies"


@pytest.mark.slow
def test_shards_are_disjoint_of_one_size_and_unite_to_the_whole(whole, tmp_path):
    _, place = whole
    shards = [place / f"shard-{number}" for number in (1, 2, 3)]
    assert [len(load_results(shard)) for shard in shards] == [6, 6, 6]
    merged = merge(shards, tmp_path / "united")
    assert (merged.rows, merged.added, merged.same) == (18, 18, 0)
    same(tmp_path / "united", place / "whole")
    results = Results(tmp_path / "united")
    assert [record["shard"] for record in results.environments] == ["1/3", "2/3", "3/3"]
    assert results.origins.value_counts().to_dict() == {1: 6, 2: 6, 3: 6}
    assert (tmp_path / "united" / "environment.json").exists()


def test_a_merge_that_was_cut_short_is_continued_by_the_same_call(whole, tmp_path):
    _, place = whole
    merge([place / "shard-1", place / "shard-2"], tmp_path / "united")
    merged = merge([place / f"shard-{number}" for number in (1, 2, 3)], tmp_path / "united")
    assert (merged.rows, merged.added, merged.same) == (18, 6, 12)
    assert len(Results(tmp_path / "united").environments) == 3
    same(tmp_path / "united", place / "whole")


def test_the_same_trial_twice_is_taken_once_and_the_most_trials_count(copied, tmp_path):
    study, place = copied
    run(study.override(trials=4), place / "shard-2", n_jobs=1, shard="2/3")
    merged = merge([place / "whole", place / "shard-2"], tmp_path / "united")
    assert (merged.rows, merged.added, merged.same) == (20, 20, 6)
    assert Results(tmp_path / "united").study.trials == 4


def test_a_finished_trial_takes_the_place_of_a_failed_one(copied, tmp_path):
    _, place = copied
    forged(place / "whole", "status = 'failed', error = 'boom', fun = NULL, trace = NULL")
    shards = [place / f"shard-{number}" for number in (1, 2, 3)]
    for order in ([place / "whole", *shards], [*shards, place / "whole"]):
        target = tmp_path / f"united-{order[0].name}"
        merge(order, target)
        assert load_results(target)["status"].eq("ok").all()


@pytest.mark.parametrize("what", ["fun = fun * (1 + 1e-15) + 1e-300", "seed = seed + 1", "nfev = nfev - 1"])
def test_conflicting_trials_are_refused_and_name_the_trial(what, copied, tmp_path):
    _, place = copied
    forged(place / "whole", what)
    shards = [place / f"shard-{number}" for number in (1, 2, 3)]
    with pytest.raises(BenchError, match=f"trial 1 of scatter on sphere-2 has another {what.split()[0]} in .*whole"):
        merge([*shards, place / "whole"], tmp_path / "united")


def test_what_cannot_be_merged_is_refused(whole, tmp_path):
    study, place = whole
    run(study.override(budget=30, trials=1), tmp_path / "other", n_jobs=1)
    with pytest.raises(BenchError, match="holds another study than"):
        merge([place / "whole", tmp_path / "other"], tmp_path / "united")
    assert not (tmp_path / "united").exists()
    with pytest.raises(BenchError, match="given twice"):
        merge([place / "whole", place / "whole"], tmp_path / "united")
    with pytest.raises(BenchError, match="given twice"):
        merge([place / "whole"], place / "whole")
    with pytest.raises(BenchError, match=r"holds no study\.toml"):
        merge([place / "whole", tmp_path], tmp_path / "united")


def test_other_data_is_refused(copied, tmp_path):
    _, place = copied
    change_data(place / "shard-1", {"sphere-2": "ba7"})
    change_data(place / "shard-2", {"sphere-2": "f00"})
    with pytest.raises(BenchError, match="or trials of other code or data; only parts of one study can be merged"):
        merge([place / "shard-1", place / "shard-2"], tmp_path / "united")


def test_verify_finds_all_trials_repeated_and_notes_it(copied):
    _, place = copied
    steps = []
    found = verify(place / "whole", n_jobs=2, on_progress=lambda *step: steps.append(step[1:]))
    assert (found.cells, found.trials, found.jobs, found.different) == (6, 12, 2, {})
    assert steps[-1] == (15, 15)  # one of each optimizer first and last
    assert Results(place / "whole").verifications[0]["sentence"] == found.sentence
    assert "12 of 12 trials of 6 cells are the same bit by bit with 2 workers" in found.sentence


def test_verify_reports_what_is_not_repeated_and_compares_whole_courses(copied):
    _, place = copied
    forged(place / "whole", "fun = fun * (1 + 1e-15) + 1e-300")
    store = Store(place / "whole")
    blob = bytearray(store.find("sphere-2", "scatter", 2)["trace"])
    blob[len(blob) // 2] ^= 1  # the last bit of the first value
    forge(store.path, f"UPDATE results SET trace = x'{blob.hex()}' WHERE trial = 2 AND cell = {SCATTER}")
    found = verify(place / "whole", trials=3, n_jobs=1)
    assert "16 of 18 trials" in found.sentence
    value, course = sorted(found.lines())
    assert value.startswith("different: scatter on sphere-2, trial 1: fun was ")
    assert course == "different: scatter on sphere-2, trial 2: another course, the same end"


@pytest.mark.slow
def test_verify_refuses_what_it_cannot_make_again(copied, tmp_path):
    _, place = copied
    with pytest.raises(BenchError, match="at least 1"):
        verify(place / "whole", trials=0)
    change_data(place / "whole", {"sphere-2": "f00"})
    with pytest.raises(BenchError, match=r"sphere-2 changed \(.*CITATION.cff\)"):
        verify(place / "whole")
    faulty = Study.from_dict({"name": "f", "trials": 1, "budget": 30, "problems": [{"name": "sphere-2"}],
                              "optimizers": [{"name": "faulty"}]})  # fmt: skip
    run(faulty, tmp_path / "none", n_jobs=1)
    with pytest.raises(BenchError, match="holds no finished trial to verify"):
        verify(tmp_path / "none")


@pytest.mark.parametrize("damaged", ["shard-2", "united"])
def test_damaged_trials_are_refused_and_named(damaged, copied):
    _, place = copied
    shards = [place / f"shard-{number}" for number in (1, 2, 3)]
    merge(shards, place / "united")
    change(place / damaged / "trials.sqlite", "UPDATE results SET nfev = nfev - 1 WHERE cell = 1")
    with pytest.raises(BenchError, match=rf"{damaged}: \d of \d+ trials are damaged \(.* trial \d"):
        merge(shards, place / "united")
