"""The format of COCO, for cocopp.

Problems of a suite that cocopp knows are written as that suite's own: function, dimension and instances, with the
suite's f_opt, so that cocopp compares them with archived data. cocopp reads no other suites, so every other problem
takes the place of a function of ``bbob-constrained``, the suite with the most functions (54) and no reference data of
its own; ignore the function names that cocopp prints for those. One call of cocopp reads one suite: a study of several
has a folder for each.

The ``.dat`` file has every improvement and the last evaluation of a run; the ``.tdat`` file has the best-so-far value
at 20 evaluation counts a decade and at the last evaluation. An evaluation of a problem of ``bbob-constrained`` counts
as one of the objective and one of the constraints, as COCO counts them; elsewhere there are none of constraints.

Source: N. Hansen, A. Auger, R. Ros, O. Mersmann, T. Tušar, D. Brockhoff, "COCO: a platform for comparing continuous
optimizers in a black-box setting", Optimization Methods and Software 36(1), 2021.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bench.analysis.cells import reference_values
from bench.contract.typing import Floats
from bench.formats.trials import OTHERS, ExportedTrial, FormatWriter, by_function, folders_of, readme
from bench.helpers.errors import BenchError
from bench.results.results import ProblemFacts, StoredResults

SUITES = {
    "bbob": range(1, 25),
    "bbob-boxed": range(1, 25),
    "bbob-constrained": range(1, 55),
    "bbob-largescale": range(1, 25),
    "bbob-mixint": range(1, 25),
    "bbob-noisy": range(101, 131),
}
"""The functions of the suites that cocopp knows."""

CONSTRAINED = "bbob-constrained"  # its functions stand for problems of no suite, too
PRECISION = 1e-8  # cocopp distinguishes no smaller difference
SMALLEST = 1e-12  # cocopp takes logarithms: a difference must be positive
INFINITE = 3e21  # COCO writes this value for infinity
STAND_IN = "stand-in for "  # the comment of such a problem, by which an import gives it its name back
SOURCES = {True: "the problem's best known value", False: "the lowest value found by any trial"}
NOTHING_FOUND = "no trial found a finite value"
COLUMNS = (
    "f evaluations | g evaluations | best noise-free fitness - Fopt ({}) | measured fitness | best measured fitness"
)


class CocoIdentity(NamedTuple):
    """The identity of a problem in COCO: its suite and the numbers of its function and instance there."""

    suite: str
    function: int
    instance: int
    own: bool  # whether the problem is that function; another one only takes its place

    @property
    def folder(self) -> str:
        """The folder of the suite, in a study of several."""
        return self.suite if self.own else OTHERS

    @property
    def g_evaluations(self) -> int:
        """The evaluations of constraints at each evaluation, as COCO counts them."""
        return int(self.own and self.suite == CONSTRAINED)


@dataclass(frozen=True)
class AssumedOptimum:
    """The value that stands for COCO's f_opt of a problem, and where the value comes from."""

    value: float
    source: str


def files(results: StoredResults) -> Iterator[tuple[str, str]]:
    """Return the path and the text of every file, one after the other.

    Raises:
        BenchError: when no trial finished, or more problems are of no suite than ``bbob-constrained`` has functions.
    """
    places, optima, names = places_in_coco(results), assumed_optima(results), optimizer_folders(results)
    return (
        (f"{where}{names[trials[0].optimizer]}/{path}", text)
        for where, trials in by_function(results, places)
        for path, text in _function_files(_algorithm(trials[0].optimizer, names), trials, places, optima)
    )


def _algorithm(label: str, folders: Mapping[str, str]) -> str:
    """Return the label as the index names it; the folder's name where the label has what would end a value there."""
    return label if re.fullmatch(r"[\w .:+()\[\]/-]+", label, re.ASCII) else folders[label]


def about(results: StoredResults) -> str:
    """Return the export's README."""
    places = places_in_coco(results)
    suites: dict[str, set[int]] = {}
    for place in places.values():
        if place.own:
            suites.setdefault(place.suite, set()).add(place.function)
    return readme(
        "coco",
        folders=optimizer_folders(results),
        where="SUITE/" if len({place.folder for place in places.values()}) > 1 else "",
        suites=suites,
        constrained=CONSTRAINED,
        stand_ins={place.function: label for label, place in places.items() if not place.own},
        optima=assumed_optima(results),
        smallest=f"{SMALLEST:g}",
        infinite=f"{INFINITE:g}",
    )


def places_in_coco(results: StoredResults) -> dict[str, CocoIdentity]:
    """Return the place of each problem, by label, in the study's order.

    Raises:
        BenchError: when more problems are of no suite of COCO than ``bbob-constrained`` has functions.
    """
    places = {entry.label: own_place(results.facts(entry.label)) for entry in results.study.problems}
    strange = [label for label, place in places.items() if place is None]
    functions = SUITES[CONSTRAINED]
    if len(strange) > len(functions):
        reason = next((f" ({why})" for label in strange if (why := results.facts(label).reason)), "")
        raise BenchError(
            f"the coco format holds at most {len(functions)} problems that are not known to be of COCO's own suites, "
            f"and this study has {len(strange)}{reason}; export fewer of them at a time, or choose ioh"
        )
    stand_ins = dict(zip(strange, functions, strict=False))
    return {
        label: place or CocoIdentity(CONSTRAINED, stand_ins[label], 1, own=False) for label, place in places.items()
    }


def own_place(facts: ProblemFacts) -> CocoIdentity | None:
    """Return the place of a problem that is a function of a suite with a known f_opt, or None."""
    suite, instance = str(facts.features.get("suite")), facts.features.get("instance")
    named = re.fullmatch(r"f(\d+)", str(facts.features.get("function")))
    number = int(named[1]) if named else 0
    if number not in SUITES.get(suite, ()) or not isinstance(instance, int) or facts.optimum is None:
        return None
    return CocoIdentity(suite, number, instance, own=True)


def optimizer_folders(results: StoredResults) -> dict[str, str]:
    """Return the folder of each optimizer, by label.

    cocopp names an algorithm after its folder, without the words ``data`` and ``noiseless``. A hyphen within these
    words keeps them, so that different names stay different.
    """
    return folders_of(results, lambda name: re.sub("(?<=dat)(?=a)|(?<=noiseles)(?=s)", "-", name))


def assumed_optima(results: StoredResults) -> dict[str, AssumedOptimum]:
    """Return the f_opt of each problem of a suite, and of the others the known optimum or the lowest value found.

    The lowest value is over the trials of all optimizers, so that all are compared with the same value. It stands for
    an optimum that is unknown or beaten. The f_opt of a suite stays what archived data were compared with.
    """
    lowest = {entry.label: np.inf for entry in results.study.problems}
    for (problem, _, _), trace in results.traces.items():
        lowest[problem] = min([lowest[problem], *trace.values[-1:].tolist()])
    known_optima = {label: optimum for label in lowest if (optimum := results.facts(label).optimum) is not None}
    places = places_in_coco(results)
    for label in lowest:
        if places[label].own:
            lowest[label] = known_optima[label]
    references = reference_values(lowest, known_optima)
    return {
        label: AssumedOptimum(value, SOURCES[known]) if np.isfinite(value) else AssumedOptimum(0.0, NOTHING_FOUND)
        for label, (value, known) in references.items()
    }


def _function_files(
    algorithm: str, trials: list[ExportedTrial], places: dict[str, CocoIdentity], optima: dict[str, AssumedOptimum]
) -> Iterator[tuple[str, str]]:
    """Yield the files of an optimizer on a function: one index, and two logs for each dimension."""
    place = places[trials[0].problem]
    index, logs = [], {}
    for dimension, group in groupby(trials, attrgetter("dimension")):
        path = f"data_f{place.function}/bbobexp_f{place.function}_DIM{dimension}"
        runs = logs[path] = [(trial, optima[trial.problem].value) for trial in group]
        head = (
            f"suite = '{place.suite}', funcId = {place.function}, DIM = {dimension}, Precision = {PRECISION:.3e}, "
            f"algId = '{algorithm}', coco_version = '2.8.2', logger = '{place.suite}', data_format = 'bbob-new2'"
        )
        comment = f"{'' if place.own else STAND_IN}{runs[0][0].problem}"
        named = [
            f"{places[trial.problem].instance}:{trial.nfev}|{_difference(trial.trace.at(trial.nfev), optimum):.1e}"
            for trial, optimum in runs
        ]
        index += [head, f"% {comment}", ", ".join([f"{path}.dat", *named])]
    yield f"bbobexp_f{place.function}.info", "\n".join([*index, ""])
    for path, runs in logs.items():
        yield f"{path}.dat", _log(((*run, run[0].evaluations) for run in runs), place.g_evaluations)
        yield f"{path}.tdat", _log(((*run, _grid(run[0].nfev)) for run in runs), place.g_evaluations)


def _log(runs: Iterable[tuple[ExportedTrial, float, NDArray[np.int64]]], g_evaluations: int) -> str:
    """Return the rows of each trial, with its f_opt and at the evaluations given with it, under a header.

    Only improvements are recorded, so the measured value is the best-so-far value; points are not recorded.
    """
    lines = []
    for trial, optimum, evaluations in runs:
        lines.append(f"% {COLUMNS.format(f'{optimum:.9e}')}")
        values = trial.trace.at(evaluations)
        measured = np.minimum(values, INFINITE)
        for row in zip(
            evaluations, evaluations * g_evaluations, _difference(values, optimum), measured, measured, strict=True
        ):
            lines.append("{:d} {:d} {:+.9e} {:+.9e} {:+.9e}".format(*row))
    return "\n".join([*lines, ""])


def _difference(values: Floats, optimum: float) -> Floats:
    """Return the values less the optimum, clipped between what COCO can take the logarithm of and its infinity."""
    return np.clip(values - optimum, SMALLEST, INFINITE)


def _grid(last: int) -> NDArray[np.int64]:
    """Return 20 evaluation counts a decade, rounded down, up to and including the last."""
    steps = np.arange(np.floor(20 * np.log10(last)) + 1)
    return np.union1d(np.floor(10 ** (steps / 20)), [1, last]).astype(np.int64)


WRITER = FormatWriter(files, about)
