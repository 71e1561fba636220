"""Many recordings: a bad one does not stop the others."""

import runpy
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from bench.helpers.errors import BenchError
from problems.backlash.joint.writing import write_recording
from problems.backlash.recordings import read_joints
from problems.backlash.sensor.batch import FEW, Failed, estimate_files
from problems.backlash.sensor.estimate import Settings
from problems.backlash.signature.datasets import noisy
from tests.problems.backlash.cut import cut

NONE = Settings(calibration=None, resamples=0)


def recording(path):
    return cut(noisy(int(path.stem)), 0.0, 0.9)


@pytest.fixture
def paths(tmp_path):
    """Files of recordings of two load turns and a bit, of growing backlash."""
    made = [tmp_path / f"{level}.csv" for level in (3, 6, 9, 12)]
    for path in made:
        write_recording(path, (part := recording(path)).time, part.speed)
    return made


def content(outcome):
    """Return an outcome as text, its arrays as bytes; its problem follows from the recording."""
    fields = vars(outcome.estimate) | vars(outcome.estimate.fit) | vars(outcome.estimate.fit.recording)
    del fields["problem"], fields["fit"]
    return {name: each.tobytes() if isinstance(each, np.ndarray) else repr(each) for name, each in fields.items()}


@pytest.mark.slow
def test_estimates_do_not_depend_on_the_number_of_workers(paths):
    several, settings = paths * (1 + FEW // len(paths)), Settings(resamples=10)
    alone = [content(each) for (each,) in estimate_files(several, read_joints, settings, n_jobs=1)]
    for jobs in (2, -1):
        assert [content(each) for (each,) in estimate_files(several, read_joints, settings, n_jobs=jobs)] == alone


def test_what_ends_its_process_costs_itself_only(tmp_path):
    """The files are programs, which their reader runs."""
    paths = [tmp_path / f"{number}.py" for number in range(FEW + 1)]
    for path in paths:
        path.write_text("raise ValueError('no recording')")
    paths[1].write_text("import os\nos.kill(os.getpid(), 9)")
    first, deadly, *others = [outcome.error for (outcome,) in estimate_files(paths, runpy.run_path, NONE, n_jobs=2)]
    assert [first, *others] == [
        f"{path}: the estimate failed with ValueError: no recording" for path in (paths[0], *paths[2:])
    ]
    assert deadly.startswith(
        f"{paths[1]}: the process that estimated it ended (signal SIGKILL), such as for want of memory; estimate it"
    )


def test_a_joint_that_cannot_be_estimated_costs_no_other_of_its_file():
    def broken():
        raise BenchError("recording cell.csv: line 7 has no number")

    joints = [("J4", partial(recording, Path("5.csv"))), ("J5", broken)]
    ((good, bad),) = estimate_files([Path("cell.csv")], lambda _: joints, NONE)
    assert (good.path, good.joint) == (Path("cell.csv"), "J4")
    assert bad == Failed(Path("cell.csv"), "recording cell.csv (J5): line 7 has no number", "J5")
