"""Many recordings: a bad one does not stop the others."""

from pathlib import Path

import pytest

import problems.backlash.sensor.batch as batch
from bench.errors import BenchError
from problems.backlash.sensor.batch import Estimated, Failed, estimate_files
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
