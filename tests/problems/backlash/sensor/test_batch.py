"""Many recordings: a bad one does not stop the others; an optimizer's seeded runs stand beside each estimate."""

import os
import signal
from pathlib import Path

import numpy as np
import pytest

import problems.backlash.sensor.batch as batch
from bench.errors import BenchError
from problems.backlash.sensor.batch import Estimated, Failed, RunSettings, estimate_files, repeat
from problems.backlash.sensor.estimate import Settings
from problems.backlash.sensor.workers import FORKS
from problems.backlash.signature.datasets import noisy

forks = pytest.mark.skipif(not FORKS, reason="a test's functions cannot be sent to a worker that is not forked")

NONE = Settings(calibration=None, resamples=0)


def read(path):
    if path.stem == "bad":
        raise BenchError(f"recording {path} is bad")
    if path.stem == "odd":
        raise BenchError("it is odd")
    return noisy(int(path.stem)).window(0.0, 0.9)


def deadly(path):
    if path.stem == "bad":
        os.kill(os.getpid(), signal.SIGKILL)
    return read(path)


def test_a_bad_file_costs_itself_only_and_is_named_in_its_sentence(monkeypatch, make_estimate):
    monkeypatch.setattr(batch, "estimate", lambda recording, settings: make_estimate())
    paths = [Path("bad.csv"), Path("5.csv"), Path("odd.csv")]
    bad, good, odd = estimate_files(paths, read, NONE)
    assert (bad, odd) == (Failed(paths[0], "recording bad.csv is bad"), Failed(paths[2], "odd.csv: it is odd"))
    assert isinstance(good, Estimated)
    assert (good.path, good.runs) == (paths[1], None)


@pytest.mark.parametrize("jobs", [0, -2, 1.5])
def test_without_a_worker_there_is_no_estimate(jobs):
    with pytest.raises(BenchError, match="jobs must be a whole number from 1 to 1000, or -1 for every core"):
        estimate_files([Path("5.csv")], read, NONE, jobs=jobs)


def test_a_fault_of_the_program_is_one_sentence_too(monkeypatch):
    def estimate(recording, settings):
        raise ZeroDivisionError("by zero\nin a line")

    monkeypatch.setattr(batch, "estimate", estimate)
    (failed,) = estimate_files([Path("5.csv")], read, NONE)
    assert failed.error == "5.csv: the estimate failed with ZeroDivisionError: by zero"


def content(outcome):
    """Return an outcome without its arrays, and those as bytes."""
    fields = vars(outcome.estimate) | vars(outcome.estimate.recording)
    return {name: each.tobytes() if isinstance(each, np.ndarray) else repr(each) for name, each in fields.items()}


@pytest.mark.slow
@forks
def test_estimates_do_not_depend_on_the_number_of_workers():
    paths = [Path(f"{level}.csv") for level in (9, 3, 12, 6, 5)]
    settings = Settings(resamples=10)
    alone = [content(each) for each in estimate_files(paths, read, settings, jobs=1)]
    for jobs in (2, 3, -1):
        assert [content(each) for each in estimate_files(paths, read, settings, jobs=jobs)] == alone


@forks
def test_a_recording_that_ends_its_process_costs_itself_only(monkeypatch, make_estimate):
    monkeypatch.setattr(batch, "estimate", lambda recording, settings: make_estimate())
    paths = [Path(name) for name in ("3.csv", "bad.csv", "5.csv", "a/bad.csv", "6.csv")]
    outcomes = list(estimate_files(paths, deadly, NONE, jobs=2))
    assert [outcome.path for outcome in outcomes] == paths
    assert [isinstance(outcome, Failed) for outcome in outcomes] == [False, True, False, True, False]
    assert outcomes[1].error.startswith(
        "bad.csv: the process that estimated it ended, such as for want of memory; estimate it alone"
    )


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
        ({"name": "gwo", "runs": 0}, "from 1 to"),
    ):
        with pytest.raises(BenchError, match=said):
            RunSettings(**options)


def test_an_optimizer_that_fails_is_one_sentence(tmp_path, make_estimate):
    (tmp_path / "mine.py").write_text("def broken(objective, rng):\n    raise ZeroDivisionError('by zero')\n")
    runs = RunSettings(f"{tmp_path / 'mine.py'}:broken", runs=2, budget=10)
    with pytest.raises(BenchError, match="failed in run 0: ZeroDivisionError: by zero"):
        repeat(make_estimate(), NONE, runs)
