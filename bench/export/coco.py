"""The format of COCO, for cocopp: the study as functions of a COCO suite.

cocopp reads only COCO's own suites. Each problem takes the place of a function of ``bbob-constrained``, the suite
with the most functions (54) and no reference data of its own; ignore the function names that cocopp prints.

The ``.dat`` file has every improvement and the last evaluation of a run; the ``.tdat`` file has the best-so-far value
at 20 evaluation counts a decade and at the last evaluation. The number of constraint evaluations is 0.

Source: N. Hansen, A. Auger, R. Ros, O. Mersmann, T. Tušar, D. Brockhoff, "COCO: a platform for comparing continuous
optimizers in a black-box setting", Optimization Methods and Software 36(1), 2021.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench import analysis
from bench.errors import BenchError
from bench.export.trials import ExportedCell, ExportedTrial, exported_cells, folders_of, readme
from bench.problem import Floats
from bench.storage.results import Results

SUITE = "bbob-constrained"
FUNCTIONS = 54
PRECISION = 1e-8  # cocopp distinguishes no smaller difference
SMALLEST = 1e-12  # cocopp takes logarithms: a difference must be positive
INFINITE = 3e21  # COCO writes this value for infinity
SOURCES = {True: "the problem's best known value", False: "the lowest value found by any trial"}
NOTHING_FOUND = "no trial found a finite value"
COLUMNS = (
    "f evaluations | g evaluations | best noise-free fitness - Fopt ({}) | measured fitness | best measured fitness"
)


@dataclass(frozen=True)
class AssumedOptimum:
    """The value that stands for COCO's f_opt of a problem, and where the value comes from."""

    value: float
    source: str


def files(results: Results) -> Iterator[tuple[str, str]]:
    """Return the path and the text of every file, one after the other.

    Raises:
        BenchError: when no trial finished, or the study has more problems than the suite has functions.
    """
    if len(results.study.problems) > FUNCTIONS:
        raise BenchError(
            f"the coco format holds at most {FUNCTIONS} problems and this study has {len(results.study.problems)}; "
            "export fewer of them at a time, or choose ioh"
        )
    folders, optima = optimizer_folders(results), assumed_optima(results)
    return (
        (f"{folders[cell.optimizer]}/{path}", text)
        for cell in exported_cells(results)
        for path, text in _cell_files(cell, folders[cell.optimizer], optima[cell.problem].value)
    )


def about(results: Results) -> str:
    """Return the export's README."""
    optima = assumed_optima(results)
    functions = [f"{label}: {optima[label].value!r}, {optima[label].source}" for label in optima]
    values = {"suite": SUITE, "smallest": SMALLEST, "infinite": INFINITE}
    return readme("coco", functions, optimizer_folders(results), **values)


def optimizer_folders(results: Results) -> dict[str, str]:
    """Return the folder of each optimizer, by label.

    cocopp names an algorithm after its folder, without the words ``data`` and ``noiseless``. A hyphen within these
    words keeps them, so that different names stay different.
    """
    return folders_of(results, lambda name: re.sub("(?<=dat)(?=a)|(?<=noiseles)(?=s)", "-", name))


def assumed_optima(results: Results) -> dict[str, AssumedOptimum]:
    """Return the known optimum of each problem, or the lowest value of all trials where that is unknown or beaten.

    The lowest value is over the trials of all optimizers, so that all are compared with the same value.
    """
    lowest = {entry.label: np.inf for entry in results.study.problems}
    for (problem, _, _), trace in results.traces.items():
        lowest[problem] = min([lowest[problem], *trace.values[-1:].tolist()])
    known_optima = {label: known for label in lowest if (known := results.facts(label).optimum) is not None}
    found = analysis.reference_values(lowest, known_optima)
    return {
        label: AssumedOptimum(value, SOURCES[known]) if np.isfinite(value) else AssumedOptimum(0.0, NOTHING_FOUND)
        for label, (value, known) in found.items()
    }


def _cell_files(cell: ExportedCell, algorithm: str, optimum: float) -> Iterator[tuple[str, str]]:
    data = f"data_f{cell.function}/bbobexp_f{cell.function}_DIM{cell.dimension}"
    yield f"bbobexp_f{cell.function}.info", _index(cell, algorithm, f"{data}.dat", optimum)
    yield f"{data}.dat", _log(((trial, trial.evaluations) for trial in cell.trials), optimum)
    yield f"{data}.tdat", _log(((trial, _grid(trial.nfev)) for trial in cell.trials), optimum)


def _index(cell: ExportedCell, algorithm: str, data: str, optimum: float) -> str:
    """Return the three lines of a function; every trial meets the same problem, so all are of instance 1."""
    head = (
        f"suite = '{SUITE}', funcId = {cell.function}, DIM = {cell.dimension}, Precision = {PRECISION:.3e}, "
        f"algId = '{algorithm}', coco_version = '2.8.2', logger = '{SUITE}', data_format = 'bbob-new2'"
    )
    finals = (_difference(trial.trace.at(trial.nfev), optimum) for trial in cell.trials)
    runs = [f"1:{trial.nfev}|{final:.1e}" for trial, final in zip(cell.trials, finals, strict=True)]
    return "\n".join([head, f"% {cell.problem}", ", ".join([data, *runs]), ""])


def _log(trials: Iterable[tuple[ExportedTrial, NDArray[np.int64]]], optimum: float) -> str:
    """Return the rows of each trial, at the evaluations given with it, under a header.

    Only improvements are recorded, so the measured value is the best-so-far value; points are not recorded.
    """
    lines = []
    for trial, evaluations in trials:
        lines.append(f"% {COLUMNS.format(f'{optimum:.9e}')}")
        values = trial.trace.at(evaluations)
        measured = np.minimum(values, INFINITE)
        for row in zip(evaluations, _difference(values, optimum), measured, measured, strict=True):
            lines.append("{:d} 0 {:+.9e} {:+.9e} {:+.9e}".format(*row))
    return "\n".join([*lines, ""])


def _difference(values: Floats, optimum: float) -> Floats:
    """Return the values less the optimum, clipped between what COCO can take the logarithm of and its infinity."""
    return np.clip(values - optimum, SMALLEST, INFINITE)


def _grid(last: int) -> NDArray[np.int64]:
    """Return 20 evaluation counts a decade, rounded down, up to and including the last."""
    steps = np.arange(np.floor(20 * np.log10(last)) + 1)
    return np.union1d(np.floor(10 ** (steps / 20)), [1, last]).astype(np.int64)
