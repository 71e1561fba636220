"""Read one study's folder, or several to compare: tidy frame, traces, study and environments."""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from fnmatch import fnmatchcase
from functools import cache, cached_property
from os import PathLike
from pathlib import Path
from typing import NamedTuple, Self, TypeVar

import pandas as pd

from bench.contract.families import dimension_in
from bench.contract.numbers import is_whole
from bench.contract.objective import integer_flags
from bench.contract.problem import Problem
from bench.helpers.errors import BenchError
from bench.helpers.parsing import JsonObject
from bench.plugins import selection
from bench.plugins.inputs import is_data, shown
from bench.plugins.loading import brings_code
from bench.results.compared import Compared
from bench.results.foreign import Table, recognised
from bench.results.sources import StudyFolder, sources
from bench.results.tidy import Tidy
from bench.results.union import differences, united
from bench.sandbox.messages import describe_error
from bench.storage.folder import DESCRIPTIONS, Folder
from bench.storage.reading import Traces
from bench.study import Study
from bench.study.cell import Labels
from bench.study.selection import Dimensions, Patterns, selected
from bench.trial.columns import FEATURES, FRAME, PRECISION
from bench.trial.scoring import Scored

AnyPath = str | PathLike[str]
T = TypeVar("T")


class Bounds(NamedTuple):
    """The bounds of a variable, and whether it is a whole number."""

    low: float
    high: float
    whole: bool = False


@dataclasses.dataclass(frozen=True)
class ProblemFacts:
    """The facts of a problem that results are measured against, as far as it can be loaded where they are read."""

    optimum: float | None = None  # its best known objective value
    expected: dict[str, tuple[float, float]] = dataclasses.field(default_factory=dict)  # metrics: true value, tolerance
    box: dict[str, Bounds] = dataclasses.field(default_factory=dict)  # by search variable
    features: dict[str, str | int] = dataclasses.field(default_factory=dict)  # what kind of problem it is
    constraints: str = ""  # how its constraints were handled; "" where it has none
    noisy: bool = False  # whether optimizers saw values with noise
    repaired_optimum: float | None = None  # the best known objective value of repaired points, where it is another one
    optimum_source: str = ""  # where the optimum is from, in words
    measure: str = ""  # what the objective value is, with its unit, in words
    reason: str = ""  # why the problem cannot be loaded, so that no fact is known

    @property
    def continuous(self) -> dict[str, tuple[float, float]]:
        """The bounds of the variables that are no whole numbers: those may well lie on a bound."""
        return {name: (low, high) for name, (low, high, whole) in self.box.items() if not whole}


class StoredResults:
    """The contents of a study's folder, or of several that can be compared, read lazily and once.

    Several folders make one study of all their problems and optimizers. An optimizer's label that occurs in several
    folders gets the folder's name, as in ``"gwo (old)"``. Where one of the folders was imported, the study has the
    problems that all folders have, or functions whose instances are repetitions, and the budgets may differ.

    Attributes:
        names: the folders' names, with as many parents as make them distinct.
        study: the study as frozen in the folder; for several folders, all their problems and optimizers; of a
            selection (:meth:`select`), those selected.
        whole: the study before any selection.
        budgets: what a run of each optimizer may spend, by the label shown; of imported runs, the most that any spent.
        planned: the trials that each cell of an optimizer should hold, by the label shown; 0 of imported runs, which
            follow no plan that is known, and of earlier versions.
        checks: the verdicts of ``bench check`` by optimizer label; empty where it has not run.
        descriptions: how the plug-ins described the optimizers when the study ran, by label, as it is noted.
        environments: one record for each run on each machine (:mod:`bench.storage.provenance`).
        differences: sentences on how the folders differ where imported results are among them; else none.
        verifications: the note of ``bench verify`` in each folder, empty where it has not run.
        versions: which version of an optimizer is shown and how many there are, where some are not shown: it was
            changed after trials of it were made.

    Raises:
        BenchError: when a folder has no study, or the folders differ in budget or in what a problem's label means,
            or imported results share no problem with the others.
    """

    def __init__(self, path: AnyPath, *others: AnyPath, versions: Sequence[str] = ()) -> None:
        self._versions = versions
        self._sources = sources([Folder(folder) for folder in (path, *others)], versions)
        self.names = [source.name for source in self._sources]
        studies = [source.study for source in self._sources]
        self.whole = united(studies, self.names, self._stored_dimension)
        self.differences = differences(studies, self.names)
        self.versions = {label: number for source in self._sources for label, number in source.versions.items()}
        self.environments = [
            {"folder": source.name} | record if others else record
            for source in self._sources
            for record in source.environments.values()
        ]
        self.verifications = [source.folder.verification() for source in self._sources]
        self._problem = cache(self._load)
        self._facts = cache(self._look_up)
        self._show(self.whole)
        if others:
            _ = self.data  # refuses what differs

    def _show(self, study: Study) -> None:
        """Have these be the results of a study: the whole one, or a selection of it."""
        self.study = study
        self.budgets = self._by_optimizer(lambda source: source.budgets)
        self.planned = self._by_optimizer(lambda source: source.planned)
        self.checks = self._by_optimizer(lambda source: source.by_label(source.folder.checks()))
        self.descriptions = self._by_optimizer(lambda source: source.by_label(source.folder.noted(DESCRIPTIONS)))

    def _by_optimizer(self, read: Callable[[StudyFolder], Mapping[str, T]]) -> dict[str, T]:
        """Return what the folders say of the study's optimizers, by label."""
        optimizers = {entry.label for entry in self.study.optimizers}
        return {label: found for each in self._sources for label, found in read(each).items() if label in optimizers}

    @property
    def data(self) -> dict[str, dict[str, str]]:
        """The hash of each file of data that a problem's trials were made from, by the problem's label.

        Raises:
            BenchError: where they differ between folders.
        """
        found: dict[str, dict[str, str]] = {entry.label: {} for entry in self.study.problems}
        for source in self._sources:
            made = source.folder.made()
            for label in found.keys() & made.keys():
                data = {shown(name): state for name, (state, _) in made[label].items() if is_data(name)}
                if any(found[label].get(name, state) != state for name, state in data.items()):
                    raise BenchError(
                        f"{source.folder.path} ran problem {label!r} on other data than {self.paths[0]}; only runs on "
                        "the same data can be compared"
                    )
                found[label] |= data
        return {label: data for label, data in found.items() if data}

    @cached_property
    def packages(self) -> dict[str, str]:
        """The version of each package that trials were made from; those of the environment are in its records."""
        made = (inputs for source in self._sources for inputs in source.folder.made().values())
        states = {name: state for inputs in made for name, (state, _) in inputs.items()}
        return {name[8:]: state.split()[0] for name, state in states.items() if name.startswith("package:") and state}

    @cached_property
    def changed(self) -> dict[str, list[str]]:
        """What trials were made from and is another by now, by the label of the problem or optimizer."""
        return {label: names for source in self._sources for label, names in source.folder.changed().items()}

    @property
    def beside(self) -> list[str]:
        """The labels of the optimizers, such as ``"mine@2"``, whose earlier versions are among the others."""
        shown = [each for source in self._sources for each in source.shown.items()]
        return [name for label, name in shown if any(fnmatchcase(label, pattern) for pattern in self._versions)]

    @property
    def partial(self) -> bool:
        """Whether this is a selection of the folders' results, or has earlier versions."""
        return self.study is not self.whole or bool(self._versions)

    def select(self, *, optimizers: Patterns = None, problems: Patterns = None, dimensions: Dimensions = None) -> Self:
        """Return the results of some optimizers on some problems, read anew.

        Whoever chooses after a look at the results chooses among claims, so a report of a selection says what it is
        selected from.

        Args:
            optimizers: one or more labels or patterns such as ``"gwo*"``; by default all.
            problems: likewise; ``"bbob-f08-d5"`` stands for all its instances.
            dimensions: one or more dimensions of problems; by default all.

        Raises:
            BenchError: for a pattern or a dimension that no optimizer or problem has, and where nothing is selected.
        """
        chosen = type(self)(*self.paths, versions=self._versions)
        chosen._problem, chosen._facts = self._problem, self._facts
        chosen._show(selected(self.study, optimizers, problems, dimensions, self.dimension))
        return chosen

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(repr(str(path)) for path in self.paths)})"

    def save(self, path: AnyPath) -> Path:
        """Copy the folder, such as that of a comparison without an output, and return the new one.

        ``bench.compare(…, output=path)`` with the same objects continues it, and ``bench report`` reads it without any.

        Raises:
            BenchError: for results of several folders, and for a new folder that cannot be written or is not empty.
        """
        if len(self._sources) > 1:
            raise BenchError(f"these are the results of {len(self._sources)} folders; save each of its own")
        return self._sources[0].folder.save(Path(path))

    @property
    def paths(self) -> list[Path]:
        """The folders, in the order given."""
        return [source.folder.path for source in self._sources]

    @property
    def frame(self) -> pd.DataFrame:
        """The tidy frame, one row a sound trial; see :func:`load_results`."""
        return self._read[0]

    def pooled(self) -> pd.DataFrame:
        """Return the frame that a report ranks and tests, for the functions of :mod:`bench.analysis`.

        Instances of a suite's function in a dimension are one problem, whose values are precisions; where budgets
        differ, values are those at the largest budget that all had. Problems that failed, instances that not all
        optimizers have, and cells whose value at that budget is unknown are left out.
        """
        return Compared(self).frame

    @property
    def origins(self) -> pd.Series:
        """The number (from 1) of the environment of each row of the frame; not a column, as it is no result."""
        return self._read[1]

    @property
    def stored(self) -> int:
        """The number of trials that the folders store, all of which are as they were written."""
        return self._read[2]

    @cached_property
    def state(self) -> str:
        """A hash of the trials and runs of the folder (:meth:`bench.storage.store.Store.state`); "" for several."""
        return self._sources[0].folder.store.state() if len(self._sources) == 1 else ""

    @property
    def histories(self) -> list[list[JsonObject]]:
        """What the runs of each folder selected, oldest first (:meth:`bench.storage.folder.Folder.history`)."""
        return [source.folder.history() for source in self._sources]

    @cached_property
    def _places(self) -> tuple[dict[str, int], dict[str, int]]:
        """The places of the study's problems, and those of its optimizers, by label."""
        problems, optimizers = (
            {entry.label: place for place, entry in enumerate(entries)}
            for entries in (self.study.problems, self.study.optimizers)
        )
        return problems, optimizers

    @cached_property
    def _shown(self) -> list[tuple[StudyFolder, dict[int, Labels]]]:
        """The folders, each with the labels of the study's cells in it by their number."""
        problems, optimizers = self._places
        return [
            (each, {cell: (p, o) for cell, (p, o) in each.cells.items() if p in problems and o in optimizers})
            for each in self._sources
        ]

    @cached_property
    def _read(self) -> tuple[pd.DataFrame, pd.Series, int]:
        """Frame, origins and the number of stored trials, which are compared with their digests."""
        tidy = Tidy()
        stored = sum(source.read(tidy, cells) for source, cells in self._shown)
        frame = tidy.frame(*self._places)
        origins = frame.pop("environment")
        return self._with_features(self._with_precision(frame)), origins, stored

    @cached_property
    def traces(self) -> Traces:
        """The anytime traces of the frame's trials by (problem, optimizer, trial); failed trials have none."""
        _ = self._read  # refuses what is damaged
        found = (source.folder.store.traces(cells).packed for source, cells in self._shown)
        return Traces({key: packed for each in found for key, packed in each.items()})

    @cached_property
    def logs(self) -> pd.DataFrame:
        """The logs of optimizers (:meth:`bench.Objective.log`): problem, optimizer, trial, name, evaluations, value."""
        _ = self._read
        rows = [
            (*key, name, *pair)
            for source, cells in self._shown
            for *key, log in source.folder.store.logs(cells)
            for name, pairs in log.items()
            for pair in pairs
        ]
        names = ["problem", "optimizer", "trial", "name", "evaluations", "value"]
        return pd.DataFrame(rows, columns=names).astype({"value": float})

    def _stored_dimension(self, label: str) -> int | None:
        finished = "problem = ? AND status = 'ok'"
        stored = (source.folder.store.rows(finished, (label,), ("x",)) for source in self._sources)
        return next((len(row["x"]) // 8 for rows in stored for row in rows), None)  # bytes of float64

    def _load(self, label: str) -> Problem:
        name = next((entry.name for entry in self.study.problems if entry.label == label), "")
        if brings_code(name) and any(source.folder.untrusted for source in self._sources):
            raise BenchError("its file holds code that nobody trusts, and is loaded in the sandbox of a run alone")
        return self.study.problem(label)

    def problem(self, label: str) -> Problem:
        """Return the problem of that label, loaded once; raises BenchError when it is not the problem that was run.

        Its data may have changed since, or its plug-in may be missing on the machine that reads the results.
        """
        problem = self._problem(label)
        if any(map(is_data, self.changed.get(label, ()))):
            raise BenchError(f"the data of problem {label!r} is no longer what the trials were made with")
        return problem

    def _with_precision(self, frame: pd.DataFrame) -> pd.DataFrame:
        """Return the frame with a column ``precision`` after ``fun``, missing where the optimum is unknown.

        Without any known optimum of a suite, and where a domain metric has that name, the frame stays as it is. No
        other problem is loaded: some compute their best known value in seconds.
        """
        suites = [entry.label for entry in self.study.problems if selection.is_of_suite(entry.name)]
        optimum = frame["problem"].map({label: self.facts(label).optimum for label in suites}).astype(float)
        if optimum.notna().any() and PRECISION.name not in frame:
            precision = pd.to_numeric(frame["fun"], errors="coerce").astype(float) - optimum
            frame.insert(list(frame).index("fun") + 1, PRECISION.name, precision)
        return frame

    def _with_features(self, frame: pd.DataFrame) -> pd.DataFrame:
        """Return the frame with the features of its problems; whole numbers stay whole where some lack.

        An optimum, which may take seconds, is not computed. A problem from a file is not loaded, as nobody expects that
        reading a frame executes the file.
        """
        kinds: list[JsonObject] = [{"dimension": dimension_in(entry.label)} for entry in self.study.problems]
        for kind, entry in zip(kinds, self.study.problems, strict=True):
            with suppress(Exception):  # a plug-in may raise anything, and may be missing here
                if not brings_code(entry.name):
                    problem = self.problem(entry.label)
                    kind |= {"dimension": problem.dimension} | dict(problem.features)
        places = frame["problem"].map(self._places[0]).to_numpy(dtype=int)
        for name in (column.name for column in FEATURES if column.name not in frame):
            values = pd.Series([kind.get(name) for kind in kinds], dtype=object)
            values = values.astype("Int64") if all(map(is_whole, values.dropna())) else values
            frame[name] = values.array.take(places)
        return frame

    def facts(self, label: str) -> ProblemFacts:
        """Return the facts of the problem of that label, as it loads on this machine; never raises."""
        return self._facts(label)

    def planned_on(self, optimizer: str, problems: Iterable[str]) -> int:
        """Return the trials that an optimizer should have on these problems in all; 0 where no plan is known."""
        run = {entry.label for each in self._sources if optimizer in each.planned for entry in each.study.problems}
        return self.planned[optimizer] * len(run & {*problems})

    def dimension(self, label: str) -> int:
        """Return the number of search variables of a problem, as it loads or by its name; 0 where neither shows it."""
        return len(self.facts(label).box) or dimension_in(label) or 0

    def _look_up(self, label: str) -> ProblemFacts:
        try:
            problem = self.problem(label)
            optima = [None if value is None else float(value) for value in (problem.optimum, problem.repaired_optimum)]
            for value in optima:
                if value is not None and not math.isfinite(value):
                    raise ValueError(f"its optimum is {value}")
            optimum, repaired = optima
            expected = {str(name): (float(true), float(near)) for name, (true, near) in problem.expected.items()}
            ends = (map(float, problem.lower), map(float, problem.upper), integer_flags(problem).tolist())
            box = dict(zip(problem.variables, map(Bounds, *ends), strict=True))
            features = {
                str(name): value if isinstance(value, int) else str(value) for name, value in problem.features.items()
            }
            handling = problem.handling if isinstance(problem, Scored) else ""
            if problem.unscored.joint:  # only its trials know whether there are any violations
                of_problem = self.frame[self.frame["problem"] == label]
                handling *= "violation" in of_problem and bool(of_problem["violation"].notna().any())
            return ProblemFacts(
                optimum,
                expected,
                box,
                features,
                constraints=handling,
                noisy=problem.unscored.noisy,
                repaired_optimum=repaired if repaired != optimum else None,
                optimum_source=str(problem.unscored.optimum_source),
                measure=str(problem.unscored.measure),
            )
        except BenchError as error:
            return ProblemFacts(reason=str(error))
        except Exception as error:  # a plug-in may raise anything
            return ProblemFacts(reason=describe_error(error))


def load_results(path: AnyPath | pd.DataFrame, *others: AnyPath) -> pd.DataFrame:
    """Return the tidy frame of a study's folder, one row a trial, in the study's order; or all rows of several folders.

    Its columns are those of :data:`bench.trial.columns.FRAME`, such as ``problem``, ``optimizer``, ``status``, ``fun``
    and ``nfev``, one ``x_<variable>`` per variable and one per domain metric. After ``fun`` comes ``precision``, which
    is ``fun`` less the known optimum, where a problem is of a suite whose optima are known; the features of the problem
    come last (:data:`bench.trial.columns.FEATURES`), missing where it has none or cannot be loaded; a metric of such a
    name stays. A failed trial's metrics are missing values, and so is what imported results do not say.

    A frame with the results of another tool, in any shape that ``bench import`` knows, gives the same columns, and a
    warning says what was taken for what.

    Raises:
        BenchError: when a frame cannot be recognised, a folder has no study, no trials or damaged ones, or the
            folders cannot be compared (:class:`StoredResults`).
    """
    if isinstance(path, pd.DataFrame):
        return _of_frame(path)
    return StoredResults(path, *others).frame


def _of_frame(table: pd.DataFrame) -> pd.DataFrame:
    """Return the tidy frame of another tool's results, one row a run."""
    cells = table if isinstance(table.index, pd.RangeIndex) else table.reset_index()
    rows, said = recognised([Table(cells, where="the frame")])
    warnings.warn("; ".join(said), stacklevel=3)
    rows = rows.rename(columns={"run": "trial", "value": "fun", "evaluations": "nfev"})
    runs = rows.groupby(["problem", "optimizer", "trial"], sort=False)
    last = runs.last().assign(fun=runs["fun"].min(), study="frame", status="ok").reset_index()
    return last.reindex(columns=[column.name for column in FRAME])
