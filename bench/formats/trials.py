"""The finished trials, each from evaluation 1 to its last, and the READMEs that all writers of formats share."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd
from jinja2 import Environment, PackageLoader, StrictUndefined
from numpy.typing import NDArray

from bench.analysis.cells import variables
from bench.contract.objective import Trace
from bench.contract.typing import Floats
from bench.helpers.errors import BenchError
from bench.helpers.text import file_name, unique
from bench.results.results import StoredResults

OTHERS = "other-problems"
"""The folder of problems of no suite, in a study of several suites."""


@dataclass(frozen=True)
class FormatWriter:
    """The writer of a format.

    Attributes:
        files: returns the path, within the export's folder, and the content of every file; raises BenchError at the
            call, not during iteration, for results that the format cannot hold.
        about: returns the part of the README that describes the files.
        holds_failures: whether the files contain failed trials.
    """

    files: Callable[[StoredResults], Iterator[tuple[str, str | bytes]]]
    about: Callable[[StoredResults], str]
    holds_failures: bool = False


@dataclass(frozen=True)
class ExportedTrial:
    """One finished trial, of an optimizer on a problem, both by label."""

    problem: str
    optimizer: str
    dimension: int  # search variables
    number: int  # from 0
    seed: int | None  # None where it is unknown, as of imported trials
    nfev: int
    x: Floats  # (d,) the best point, (0,) where it is unknown
    trace: Trace
    log: Mapping[str, Trace] = field(default_factory=dict)  # what the optimizer logged, by name

    @property
    def evaluations(self) -> NDArray[np.int64]:
        """(m,) int64: evaluation 1, every improvement and the last evaluation, increasing."""
        return np.union1d(self.trace.evaluations, [1, self.nfev]).astype(np.int64)


def by_function(results: StoredResults, places: Mapping[str, Any]) -> list[tuple[str, list[ExportedTrial]]]:
    """Return for each optimizer and function the beginning of its files' paths and its finished trials.

    The beginning is the folder of the suite with a slash, "" where all problems are of one. Trials are in the order of
    dimensions and instances.

    Args:
        results: what is exported.
        places: the place of each problem in the format, by label: its ``folder``, ``function`` and ``instance``.

    Raises:
        BenchError: when no trial finished.
    """
    finished = results.frame[results.frame["status"] == "ok"]
    if finished.empty:
        raise BenchError("no trial of this study finished, and this format holds no others; csv and parquet hold all")
    logs: dict[tuple[Hashable, ...], dict[str, Trace]] = {}
    for (*key, name), rows in results.logs.dropna().groupby(["problem", "optimizer", "trial", "name"], sort=False):
        logged = Trace(rows["evaluations"].to_numpy(np.int64), rows["value"].to_numpy(np.float64))
        logs.setdefault(tuple(key), {})[str(name)] = logged
    several = len({place.folder for place in places.values()}) > 1
    functions: dict[tuple[str, str, int], list[ExportedTrial]] = {}
    for problem, rows in finished.groupby("problem", sort=False):
        place, points = places[str(problem)], rows[variables(rows)].to_numpy(dtype=np.float64)
        dimension = points.shape[1] or results.dimension(str(problem))
        columns = (rows[name].tolist() for name in ("optimizer", "trial", "seed", "nfev"))
        for optimizer, number, seed, nfev, x in zip(*columns, points, strict=True):
            trace = results.traces[str(problem), optimizer, number]
            seed = None if pd.isna(seed) else int(seed)
            log = logs.get((str(problem), optimizer, number), {})
            trial = ExportedTrial(str(problem), optimizer, dimension, number, seed, int(nfev), x, trace, log)
            functions.setdefault((f"{place.folder}/" * several, optimizer, place.function), []).append(trial)
    return [
        (folder, sorted(trials, key=lambda trial: (trial.dimension, places[trial.problem].instance)))
        for (folder, _, _), trials in functions.items()
    ]


def folders_of(results: StoredResults, rename: Callable[[str], str] = str) -> dict[str, str]:
    """Return the folder of each optimizer, by label: its file name, changed by ``rename`` and made unique."""
    labels = [entry.label for entry in results.study.optimizers]
    return dict(zip(labels, unique(rename(file_name(label)) for label in labels), strict=True))


def readme(kind: str, **values: object) -> str:
    """Return the README of a kind of files: the template of that name in the folder ``readme``, with its values."""
    loader = PackageLoader("bench.formats", "readme")
    templates = Environment(loader=loader, undefined=StrictUndefined, trim_blocks=True, keep_trailing_newline=True)
    return templates.get_template(f"{kind}.txt").render(values)


def omission_notes(frame: pd.DataFrame) -> list[str]:
    """Return a sentence for each optimizer with unfinished trials: a trial that did not finish has no trace."""
    unfinished = frame[frame["status"] != "ok"]
    sentences = []
    for optimizer, rows in unfinished.groupby("optimizer", sort=False):
        where = ", ".join(
            f"{count} on {problem}" for problem, count in rows["problem"].value_counts(sort=False).items()
        )
        sentences.append(
            f"Left out, because this format holds no failures: {len(rows)} of the trials of {optimizer} ({where}). "
            f"Statistics of this export therefore flatter {optimizer}."
        )
    return sentences
