"""The format of IOHprofiler, for IOHanalyzer and iohinspector.

Each optimizer has a folder with a JSON file about the runs on each problem and a ``.dat`` file of their best-so-far
values. A run is logged at its first evaluation, at every improvement and at its last evaluation.

Source: J. de Nobel, F. Ye, D. Vermetten, H. Wang, C. Doerr, T. Bäck, "IOHexperimenter: Benchmarking Platform for
Iterative Optimization Heuristics", Evolutionary Computation 32(3), 2024.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

from bench.errors import BenchError
from bench.export.trials import ExportedCell, ExportedTrial, exported_cells, folders_of, readme, readme_lines
from bench.helpers.text import file_name
from bench.storage.results import Results

VERSION = "0.3.22"  # of the format
LARGEST_FUNCTION = 2**16 - 1  # readers store a function's number in 16 bits
COLUMNS = ["evaluations", "raw_y"]


def files(results: Results) -> Iterator[tuple[str, str]]:
    """Return the path and the text of every file, one after the other.

    Raises:
        BenchError: when no trial finished, or the study has more problems than the format can number.
    """
    if len(results.study.problems) > LARGEST_FUNCTION:
        raise BenchError(f"the ioh format holds at most {LARGEST_FUNCTION:,} problems; export fewer of them at a time")
    folders = folders_of(results)
    attributes = _experiment_attributes(results.environments)
    return (
        (f"{folders[cell.optimizer]}/{path}", text)
        for cell in exported_cells(results)
        for path, text in _cell_files(cell, results.study.name, attributes)
    )


def about(results: Results) -> str:
    """Return the export's README."""
    functions = dict(enumerate((entry.label for entry in results.study.problems), start=1))
    folders = {folder: label for label, folder in folders_of(results).items()}
    return readme("ioh", functions=readme_lines(functions), folders=readme_lines(folders))


def _cell_files(cell: ExportedCell, suite: str, attributes: list[dict[str, str]]) -> Iterator[tuple[str, str]]:
    name = f"f{cell.function}_{file_name(cell.problem)}"
    data = f"data_{name}/IOHprofiler_f{cell.function}_DIM{cell.dimension}.dat"
    head = {
        "version": VERSION,
        "suite": suite,
        "function_id": cell.function,
        "function_name": cell.problem,
        "maximization": False,
        "algorithm": {"name": cell.optimizer, "info": ""},
        "experiment_attributes": attributes,
        "run_attributes": ["trial", "seed"],
        "attributes": COLUMNS,
        "scenarios": [{"dimension": cell.dimension, "path": data, "runs": [_run(trial) for trial in cell.trials]}],
    }
    yield f"IOHprofiler_{name}.json", json.dumps(head, indent=1, allow_nan=False) + "\n"
    yield data, "".join(_log(trial) for trial in cell.trials)


def _run(trial: ExportedTrial) -> dict[str, Any]:
    """Return the entry of a trial; every trial meets the same problem, so all are of instance 1."""
    found = len(trial.trace.values) > 0
    best = {
        "evals": int(trial.trace.evaluations[-1]) if found else trial.nfev,
        "y": float(trial.trace.values[-1]) if found else None,
        "x": [value if math.isfinite(value) else None for value in trial.x.tolist()],
    }
    return {"instance": 1, "evals": trial.nfev, "best": best, "trial": trial.number, "seed": trial.seed}


def _log(trial: ExportedTrial) -> str:
    """Return the rows of a trial under their header; Python's shortest exact decimals lose no digit."""
    rows = zip(trial.evaluations.tolist(), trial.trace.at(trial.evaluations).tolist(), strict=True)
    return "".join([f"{' '.join(COLUMNS)}\n", *(f"{evaluation} {value!r}\n" for evaluation, value in rows)])


def _experiment_attributes(environments: list[dict[str, Any]]) -> list[dict[str, str]]:
    """Return the commits of the code that made the trials, where they are known."""
    states = [environment.get("git") or {} for environment in environments]
    commits = [f"{git['commit']}{'-dirty' if git.get('dirty') else ''}" for git in states if git.get("commit")]
    return [{"git_sha": "+".join(dict.fromkeys(commits))}] if commits else []
