"""Many recordings: a bad one does not stop the others; an optimizer's seeded runs stand beside each estimate."""

from pathlib import Path

import pytest

import problems.backlash.sensor.batch as batch
from bench.errors import BenchError
from problems.backlash.sensor.batch import Estimated, Failed, RunSettings, estimate_files, repeat
from problems.backlash.sensor.estimate import Settings
from problems.backlash.signature.datasets import noisy

NONE = Settings(calibration=None, resamples=0)


def read(path):
    if path.stem == "bad":
        raise BenchError(f"recording {path} is bad")
    if path.stem == "odd":
        raise BenchError("it is odd")
    return noisy(int(path.stem)).window(0.0, 0.9)


def test_a_bad_file_costs_itself_only_and_is_named_in_its_sentence(monkeypatch, make_estimate):
    monkeypatch.setattr(batch, "estimate", lambda recording, settings: make_estimate())
    paths = [Path("bad.csv"), Path("5.csv"), Path("odd.csv")]
    bad, good, odd = estimate_files(paths, read, NONE)
    assert (bad, odd) == (Failed(paths[0], "recording bad.csv is bad"), Failed(paths[2], "odd.csv: it is odd"))
    assert isinstance(good, Estimated)
    assert (good.path, good.runs) == (paths[1], None)


def test_without_a_worker_there_is_no_estimate():
    with pytest.raises(BenchError, match="at least one worker"):
        estimate_files([Path("5.csv")], read, NONE, jobs=0)


@pytest.fixture(scope="module")
def found():
    runs = RunSettings("random-search", runs=3, budget=400)
    (found,) = estimate_files([Path("8.csv")], lambda _: noisy(8).window(0.0, 0.9), NONE, runs)
    return found


def test_runs_of_an_optimizer_are_seeded_and_their_sizes_have_no_sign(found):
    runs = found.runs
    assert runs.sizes_rps.shape == runs.values_rps.shape == runs.backlashes_rad.shape == (3,)
    assert (runs.sizes_rps > 0).all()
    assert len(set(runs.values_rps)) == 3
    assert (runs.values_rps >= found.estimate.rmse_rps).all()  # the reference fit is the best
    again = repeat(found.estimate, NONE, RunSettings("random-search", runs=3, budget=400))
    assert again.values_rps.tolist() == runs.values_rps.tolist()
    other = repeat(found.estimate, NONE, RunSettings("random-search", runs=3, budget=400, seed=1))
    assert not set(other.values_rps) & set(runs.values_rps)


def test_a_run_has_found_the_best_fit_within_a_percent_of_its_rmse(found, make_estimate):
    values = found.runs.values_rps
    second = sorted(values)[1]
    for rmse, count in ((second / 1.009, 2), (second / 1.011, 1), (min(values) / 1.011, 0)):
        estimate = make_estimate(recording=found.estimate.recording, period_s=0.4, rmse_rps=rmse)
        assert repeat(estimate, NONE, RunSettings("random-search", runs=3, budget=400)).found == count


def test_an_optimizer_is_checked_before_any_recording_is_read():
    for options, said in (
        ({"name": "gwoo"}, "did you mean 'gwo'"),
        ({"name": "gwo", "options": {"agent": 3}}, "no parameter 'agent'"),
        ({"name": "gwo", "budget": 3}, "below one generation"),
        ({"name": "gwo", "runs": 0}, "at least 1"),
    ):
        with pytest.raises(BenchError, match=said):
            RunSettings(**options)


def test_an_optimizer_that_fails_is_one_sentence(tmp_path, make_estimate):
    (tmp_path / "mine.py").write_text("def broken(objective, rng):\n    raise ZeroDivisionError('by zero')\n")
    runs = RunSettings(f"{tmp_path / 'mine.py'}:broken", runs=2, budget=10)
    with pytest.raises(BenchError, match="failed in run 0: ZeroDivisionError: by zero"):
        repeat(make_estimate(), NONE, runs)
