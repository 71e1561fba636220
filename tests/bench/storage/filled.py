"""A small study's folder that is filled by hand, and what is said of its damage."""

import random
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from bench import BenchError, Results, Study
from bench.contract.objective import Trace
from bench.storage.folder import Folder
from bench.trial.columns import packed
from bench.trial.trial import Trial

DATA = Path(__file__).resolve().parents[3] / "CITATION.cff"
"""A file that is there."""

PROBLEMS, OPTIMIZERS, TRIALS = ("sphere-2", "sphere-3"), ("scatter", "early"), 30


def rows():
    """Yield trials and rows, of which some failed."""
    rng = random.Random(3)
    for number in range(TRIALS):
        for problem in PROBLEMS:
            for optimizer in OPTIMIZERS:
                count = rng.randint(1, 12)
                values = np.array([rng.random() for _ in range(count)])
                row = {
                    "status": "ok", "fun": rng.random(), "nfev": 60, "wall_s": rng.random(), "cpu_s": rng.random(),
                    "objective_s": rng.random(), "stop": "budget", "outside_box": rng.randrange(2),
                    "x": {"x1": rng.random(), "x2": -0.0}, "metrics": {"radius": rng.random()},
                    "trace": Trace(np.arange(1, count + 1), values),
                }  # fmt: skip
                lost = {"status": "failed", "error": "RuntimeError: ä no"}
                yield Trial(problem, optimizer, number, rng.getrandbits(62)), lost if number % 10 == 3 else row


RECORD = {"host": "here", "started": "2026-01-01T00:00:00+00:00", "packages": {f"p{i}": "1.2.3" for i in range(40)}}


def add_missing(folder):
    """Store the trials that a folder lacks, as a run does that makes them again with the same outcome."""
    done = folder.store.keys()
    missing = [each for each in rows() if each[0].key not in done]
    if missing:
        with folder.store.writer() as writer:
            number = writer.record("environments", RECORD)
            for trial, row in missing:
                writer.add(trial, packed(row), number)


def filled_folder(path, **more):
    """Return the folder of a study, with further keys of its file, that holds all 120 trials."""
    path.mkdir()
    folder = Folder(path)
    lists = {"problems": [{"names": [*PROBLEMS]}], "optimizers": [{"name": name} for name in OPTIMIZERS]}
    folder.claim(Study.from_dict({"name": "small", "trials": TRIALS, "budget": 60} | lists | more))
    add_missing(folder)
    return folder


def traces(results):
    return {key: (each.evaluations.tobytes(), each.values.tobytes()) for key, each in results.traces.items()}


def change_data(path, data):
    """Have the trials of a folder be of problems with other data, by the hash of each."""
    store = Folder(path).store
    with store.reader() as reader:
        cells = {n: data[cell.labels[0]] for n, cell in reader.cells.all.items() if cell.labels[0] in data}
        rows = [(cell, row) for cell, row in reader.sound() if cell in cells]
    with store.writer() as writer:
        writer.remove(cells)
        made = {
            state: writer.record("inputs", {"problem": {f"file:{DATA}": [state, []]}, "optimizer": {}})
            for state in data.values()
        }
        with writer.transaction():
            for cell, row in rows:
                writer.put(row | {"inputs": made[cells[cell]]}, cell)


def assert_refused(folder):
    """No run adds to a damaged store, which stays as it is."""
    before = folder.store.path.read_bytes()
    with pytest.raises(BenchError):
        folder.require_sound()
    assert folder.store.path.read_bytes() == before


def damage_of(folder, original, frame, known):
    """Return what is said of a folder's damage, "" where all that is read equals the original."""
    try:
        results = Results(folder.path)
        pd.testing.assert_frame_equal(results.frame, frame, check_exact=True)
    except BenchError as error:
        return str(error)
    assert traces(results) == known
    assert results.environments == original.environments
    return ""
