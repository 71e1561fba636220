"""The format of IOHprofiler, for IOHanalyzer and iohinspector.

Each optimizer has a folder with a JSON file about the runs on each function and, for each dimension, a ``.dat`` file of
their best-so-far values. A run is logged at its first evaluation, at every improvement and at its last evaluation; what
the optimizer logged itself stands in further columns.

Problems of a suite keep its function and instance. Their values are logged less f_opt, as IOHexperimenter logs those of
BBOB, so that instances can be put together; f_opt is an attribute of each run. bbob has IOHexperimenter's names of
suite and functions, so that readers lay it over data of that package. Every other problem is a function of its own.

Source: J. de Nobel, F. Ye, D. Vermetten, H. Wang, C. Doerr, T. Bäck, "IOHexperimenter: Benchmarking Platform for
Iterative Optimization Heuristics", Evolutionary Computation 32(3), 2024.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from bench.contract.objective import Trace
from bench.formats.trials import OTHERS, ExportedTrial, FormatWriter, by_function, folders_of, readme
from bench.helpers.errors import BenchError
from bench.helpers.parsing import JsonObject
from bench.helpers.text import file_name
from bench.results.results import StoredResults

VERSION = "0.3.22"  # of the format
LARGEST = 2**16 - 1  # readers store numbers of functions and instances in 16 bits
COLUMNS = ["evaluations", "raw_y"]
F_OPT = "f_opt"
"""The attribute of a run that has what its logged values lack; runs on problems of no suite do not have it."""

BBOB = (
    "Sphere", "Ellipsoid", "Rastrigin", "BuecheRastrigin", "LinearSlope", "AttractiveSector", "StepEllipsoid",
    "Rosenbrock", "RosenbrockRotated", "EllipsoidRotated", "Discus", "BentCigar", "SharpRidge", "DifferentPowers",
    "RastriginRotated", "Weierstrass", "Schaffers10", "Schaffers1000", "GriewankRosenBrock", "Schwefel",
    "Gallagher101", "Gallagher21", "Katsuura", "LunacekBiRastrigin",
)  # fmt: skip
"""IOHexperimenter's names of the functions of BBOB, which SBOX has too."""

SUITES = {"bbob": "BBOB", "sbox-cost": "SBOX"}
"""The suites with these functions, and what IOHexperimenter calls them."""


class IohIdentity(NamedTuple):
    """The identity of a problem for readers of IOH files: the suite, the function's number and name, and the instance.

    ``optimum`` is what logged values lack, None for a problem of no suite.
    """

    suite: str
    function: int
    name: str
    instance: int
    optimum: float | None

    @property
    def folder(self) -> str:
        """The folder of the suite, in a study of several."""
        return OTHERS if self.optimum is None else file_name(self.suite.lower())


def files(results: StoredResults) -> Iterator[tuple[str, str]]:
    """Return the path and the text of every file, one after the other.

    Raises:
        BenchError: when no trial finished, or the study has more problems than the format can number.
    """
    if len(results.study.problems) > LARGEST:
        raise BenchError(f"the ioh format holds at most {LARGEST:,} problems; export fewer of them at a time")
    places, folders = places_in_ioh(results), folders_of(results)
    attributes = _experiment_attributes(results.environments)
    return (
        (f"{where}{folders[trials[0].optimizer]}/{path}", text)
        for where, trials in by_function(results, places)
        for path, text in _function_files(trials, places, attributes)
    )


def about(results: StoredResults) -> str:
    """Return the export's README."""
    places = {(place.suite, place.function): place for place in places_in_ioh(results).values()}
    return readme("ioh", places=places.values(), folders=folders_of(results))


def places_in_ioh(results: StoredResults) -> dict[str, IohIdentity]:
    """Return the place of each problem, by label: in its suite where its label is its name there, else in the study."""
    numbers: dict[tuple[str, str], int] = {}
    places = {}
    for number, entry in enumerate(results.study.problems, start=1):
        facts = results.facts(entry.label)
        suite, function = str(facts.features.get("suite", "")), str(facts.features.get("function", ""))
        instance = facts.features.get("instance", 1)
        if not suite or not function or entry.label != entry.name or not 0 < int(instance) <= LARGEST:
            places[entry.label] = IohIdentity(results.study.name, number, entry.label, 1, None)
            continue
        if named := re.fullmatch(r"f(\d+)", function):
            position = int(named[1])
        else:
            position = numbers.setdefault((suite, function), sum(known == suite for known, _ in numbers) + 1)
        name = BBOB[position - 1] if suite in SUITES else function
        places[entry.label] = IohIdentity(SUITES.get(suite, suite), position, name, int(instance), facts.optimum or 0.0)
    return places


def _function_files(
    trials: list[ExportedTrial], places: dict[str, IohIdentity], attributes: list[dict[str, str]]
) -> Iterator[tuple[str, str]]:
    """Yield the files of an optimizer's runs on a function: one index, and a log for each dimension."""
    place = places[trials[0].problem]
    name = f"f{place.function}_{file_name(place.name.lower())}"
    scenarios: dict[int, list[tuple[IohIdentity, ExportedTrial]]] = {}
    for trial in trials:
        scenarios.setdefault(trial.dimension, []).append((places[trial.problem], trial))
    names = list(dict.fromkeys(name for trial in trials for name in trial.log))
    logs = {dimension: f"data_{name}/IOHprofiler_f{place.function}_DIM{dimension}.dat" for dimension in scenarios}
    head = {
        "version": VERSION,
        "suite": place.suite,
        "function_id": place.function,
        "function_name": place.name,
        "maximization": False,
        "algorithm": {"name": trials[0].optimizer, "info": ""},
        "experiment_attributes": attributes,
        "run_attributes": ["trial", "seed", *([] if place.optimum is None else [F_OPT])],
        "attributes": [*COLUMNS, *names],
        "scenarios": [
            {"dimension": dimension, "path": logs[dimension], "runs": [_run(*run) for run in runs]}
            for dimension, runs in scenarios.items()
        ],
    }
    yield f"IOHprofiler_{name}.json", json.dumps(head, indent=1, allow_nan=False) + "\n"
    for dimension, runs in scenarios.items():
        yield logs[dimension], "".join(_log(*run, names) for run in runs)


def _run(place: IohIdentity, trial: ExportedTrial) -> JsonObject:
    """Return the entry of a trial."""
    trace = _above(place, trial)
    reached = len(trace.values) > 0
    best = {
        "evals": int(trace.evaluations[-1]) if reached else trial.nfev,
        "y": float(trace.values[-1]) if reached else None,
        "x": [value if math.isfinite(value) else None for value in trial.x.tolist()],
    }
    f_opt = {} if place.optimum is None else {F_OPT: place.optimum}
    return {
        "instance": place.instance, "evals": trial.nfev, "best": best, "trial": trial.number, "seed": trial.seed,
        **f_opt,
    }  # fmt: skip


def _above(place: IohIdentity, trial: ExportedTrial) -> Trace:
    """Return a trial's trace less f_opt."""
    return Trace(trial.trace.evaluations, trial.trace.values - (place.optimum or 0.0))


def _log(place: IohIdentity, trial: ExportedTrial, names: list[str]) -> str:
    """Return the rows of a trial under their header; Python's shortest exact decimals lose no digit.

    What the optimizer logged under ``names`` stands behind the values: the last one so far, nan before the first.
    """
    at = trial.evaluations
    columns = [at.tolist(), _above(place, trial).at(at).tolist()]
    for name in names:
        logged = trial.log[name].at(at) if name in trial.log else np.full(len(at), np.nan)
        columns.append(np.where(np.isfinite(logged), logged, np.nan).tolist())
    rows = (" ".join(map(repr, row)) for row in zip(*columns, strict=True))
    return "".join([f"{' '.join([*COLUMNS, *names])}\n", *(f"{row}\n" for row in rows)])


def _experiment_attributes(environments: list[JsonObject]) -> list[dict[str, str]]:
    """Return the commits of the code that made the trials, where they are known."""
    states = [environment.get("git") or {} for environment in environments]
    commits = [f"{git['commit']}{'-dirty' if git.get('dirty') else ''}" for git in states if git.get("commit")]
    return [{"git_sha": "+".join(dict.fromkeys(commits))}] if commits else []


WRITER = FormatWriter(files, about)
