"""Many recordings: a bad one does not stop the others; an optimizer's seeded runs stand beside each estimate."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest

import problems.backlash.sensor.batch as batch
from bench.errors import BenchError
from problems.backlash.joint.writing import write_recording
from problems.backlash.recordings import read_joints
from problems.backlash.sensor.batch import Estimated, Failed, RunSettings, estimate_files, repeat
from problems.backlash.sensor.estimate import Settings
from problems.backlash.signature.datasets import noisy

NONE = Settings(calibration=None, resamples=0)


def read(path):
    if path.stem == "bad":
        raise BenchError(f"recording {path} is bad")
    if path.stem == "odd":
        raise BenchError("it is odd")
    return [("", partial(recording, path))]


def recording(path):
    return noisy(int(path.stem)).window(0.0, 0.9)


@pytest.fixture
def paths(tmp_path):
    """Files of recordings of two load turns and a bit, of growing backlash."""
    made = [tmp_path / f"{level}.csv" for level in (3, 6, 9, 12)]
    for path in made:
        write_recording(path, (part := recording(path)).time, part.speed)
    return made


def test_a_bad_file_costs_itself_only_and_is_named_in_its_sentence(monkeypatch, make_estimate):
    monkeypatch.setattr(batch, "estimate", lambda recording, settings: make_estimate())
    paths = [Path("bad.csv"), Path("5.csv"), Path("odd.csv")]
    (bad,), (good,), (odd,) = estimate_files(paths, read, NONE)
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
    ((failed,),) = estimate_files([Path("5.csv")], read, NONE)
    assert failed.error == "5.csv: the estimate failed with ZeroDivisionError: by zero"


def content(outcome):
    """Return an outcome as text, its arrays as bytes; its problem follows from the recording."""
    fields = vars(outcome.estimate) | vars(outcome.estimate.recording)
    del fields["problem"]
    return {name: each.tobytes() if isinstance(each, np.ndarray) else repr(each) for name, each in fields.items()}


@pytest.mark.slow
def test_estimates_do_not_depend_on_the_number_of_workers(paths, monkeypatch):
    monkeypatch.setattr(batch, "FEW", 1)
    settings = Settings(resamples=10)
    alone = [content(each) for (each,) in estimate_files(paths, read_joints, settings, jobs=1)]
    for jobs in (2, 3, -1):
        assert [content(each) for (each,) in estimate_files(paths, read_joints, settings, jobs=jobs)] == alone


DEADLY = """
import os
def deadly(objective, rng):
    if objective.upper[0] < {most}:
        os.kill(os.getpid(), 9)
    objective(objective.initial(1))
"""


def test_what_ends_its_process_costs_itself_only(paths, monkeypatch, tmp_path):
    """The bound of A grows with the disturbance."""
    monkeypatch.setattr(batch, "FEW", 1)
    (tmp_path / "mine.py").write_text(DEADLY.format(most=np.ptp(recording(paths[1]).speed) / 2))
    runs = RunSettings(f"{tmp_path / 'mine.py'}:deadly", runs=1, budget=10)
    outcomes = [outcome for (outcome,) in estimate_files(paths, read_joints, NONE, runs, jobs=2)]
    assert [outcome.path for outcome in outcomes] == paths
    assert [isinstance(outcome, Failed) for outcome in outcomes] == [True, False, False, False]
    assert outcomes[0].error.startswith(
        f"{paths[0]}: the process that estimated it ended (signal SIGKILL), such as for want of memory; estimate it"
    )


def test_a_joint_that_cannot_be_estimated_costs_no_other_of_its_file(monkeypatch, make_estimate):
    def broken():
        raise BenchError("recording cell.csv: line 7 has no number")

    monkeypatch.setattr(batch, "estimate", lambda recording, settings: make_estimate())
    joints = [("J4", lambda: None), ("J5", broken)]
    ((good, bad),) = estimate_files([Path("cell.csv")], lambda _: joints, NONE)
    assert (good.path, good.joint) == (Path("cell.csv"), "J4")
    assert bad == Failed(Path("cell.csv"), "recording cell.csv (J5): line 7 has no number", "J5")


@pytest.fixture(scope="module")
def found():
    runs = RunSettings("random-search", runs=3, budget=400)
    ((found,),) = estimate_files([Path("8.csv")], read, NONE, runs)
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
        estimate = make_estimate(problem=found.estimate.problem, rmse_rps=rmse)
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
