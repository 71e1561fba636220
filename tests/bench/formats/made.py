"""Studies with made-up trials to export, and the scripts' runner that reads an export in a process of its own."""

import json
import math
import os
import subprocess
import sys
from itertools import accumulate

import numpy as np
import pandas as pd
import pytest

from bench import Results, Trace
from bench.formats.exporting import export
from bench.storage.folder import Folder
from bench.study import Entry, Study
from bench.trial.columns import packed

HOSTILE = ("gwo", "GWO", "../../x", "<script>", "日本", "database", "base", "dat-abase", "'q', a = \"1\"", "NA")
BUDGET = 120

# The readers run apart: they set up matplotlib for themselves, and cocopp asks the network and writes to the home.
ISOLATE = """
import json, os, socket, sys, warnings
def refuse(*args, **kwargs): raise OSError("no network")
socket.getaddrinfo = refuse
os.environ["HOME"] = os.environ["USERPROFILE"] = sys.argv[2]
"""


def read(script, folder, home, *arguments):
    """Return what a reader's script prints last, as JSON."""
    command = [sys.executable, "-c", ISOLATE + script, str(folder), str(home), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, "PYTHONUTF8": "1"})
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def search(rng, length):
    """Return the values of a made-up search that closes in on 0 and begins with infinite ones."""
    return np.concatenate(
        ([np.inf] * int(rng.integers(0, 3)), np.exp(3 * rng.normal(size=length) - np.arange(length) / 9))
    )


def record(values, d, **changes):
    best = list(accumulate(values, min))
    at = [i for i, value in enumerate(best) if value < (best[i - 1] if i else math.inf)]
    trace = Trace(np.array(at, dtype=np.int64) + 1, np.array([best[i] for i in at], dtype=np.float64))
    return {
        "status": "ok", "fun": best[-1], "nfev": len(values), "calls": 1 + len(values) // 7, "wall_s": 0.1 + 0.2,
        "cpu_s": 1 / 3, "objective_s": 1e-9, "memory_mb": 2 / 3, "stop": "budget", "outside_box": 0,
        "x": {f"x{i}": i / 7 for i in range(d)}, "metrics": {}, "trace": trace,
    } | changes  # fmt: skip


FAILED = {"status": "failed", "error": 'ValueError: boom, "really"\r\n\tTraceback\rmore'}


def make(folder, problems=None, optimizers=("a", "b"), trials=4, row=None):
    """Write a study; ``problems`` maps labels to dimensions, ``row`` may give a trial's row."""
    problems = problems or {"sphere-2": 2, "p": 3}
    entries = tuple(Entry(label, label) for label in problems), tuple(Entry("any", label) for label in optimizers)
    study, rng = Study("made", *entries, trials=trials, budget=BUDGET), np.random.default_rng(0)
    place = Folder(folder)
    place.path.mkdir(parents=True, exist_ok=True)
    place.claim(study)
    with place.store.writer() as writer:
        for trial in study.plan():
            values = search(rng, int(rng.integers(1, BUDGET - 3)))
            given = row(trial, values) if row else None
            writer.add(trial, packed(given or record(values, problems[trial.problem])))
    return Results(folder)


def exported(results, kind, folder):
    """Export the results and return the folder."""
    export(results, kind, folder)
    return folder


def contents(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def some_fail(trial, values):
    if trial.optimizer == "a" and trial.number in (1, 2):
        return FAILED
    return record([math.inf] * 7, 2) if trial.problem == "never" else None


def needs(kind):
    if kind == "parquet":
        pytest.importorskip("pyarrow", reason="Parquet needs pyarrow")


def precision_targets(functions, precisions):
    """The targets of functions whose values are precisions."""
    rows = [(function, precision, precision) for function in functions for precision in precisions]
    return pd.DataFrame(rows, columns=["problem", "tau", "target"])
