"""Read an archive for the board: unpack it, verify it, and keep what is ranked and where it comes from."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bench.errors import BenchError
from bench.families import dimension_in
from bench.formats.archive import unpack
from bench.formats.source import sha256_of
from bench.helpers.text import count, printable
from bench.plugins.loading import family
from bench.plugins.registry import DISTRIBUTION
from bench.storage.folder import Folder
from bench.study import Study
from bench.typing import Floats

LONGEST = 100  # characters shown of a text of an archive, which may hold anything


@dataclass(frozen=True, order=True)
class Setting:
    """The conditions that two results must share to be compared.

    Attributes:
        suite: the family of the problems.
        dimension: their number of variables.
        budget: the evaluations of a trial.
        problems: label, name, options and hash of the data of each problem, as JSON.
        constraints: what optimizers saw of infeasible points.
        looks: the declared looks, which stop cells early.
        alone: the archive of imported trials, whose budgets nobody set; "" of others.
    """

    suite: str
    dimension: int
    budget: int
    problems: tuple[str, ...]
    constraints: str
    looks: tuple[int, ...]
    alone: str

    @property
    def title(self) -> str:
        """The conditions in words."""
        shared = f"{printable(self.suite, LONGEST)}, d = {self.dimension:,}, {self.budget:,} evaluations"
        return f"{shared}, {count(len(self.problems), 'problem')}" + f", imported in {self.alone}" * bool(self.alone)

    @property
    def labels(self) -> list[str]:
        """The labels of the problems, in order."""
        return [json.loads(problem)[0] for problem in self.problems]


@dataclass(frozen=True)
class Again:
    """A trial that was made again: ``different`` says how it differs, ``reason`` why it could not be made."""

    trial: str
    different: str = ""
    reason: str = ""

    @property
    def sentence(self) -> str:
        """The outcome in a few words."""
        outcome = f"not made again: {self.reason}" if self.reason else self.different and f"differs: {self.different}"
        return outcome or "the same bit by bit"


@dataclass(frozen=True)
class Archive:
    """A verified archive.

    Attributes:
        name: the name of its file.
        sha256: the hash of its file.
        study: the study.
        records: the environments that made its trials, oldest first.
        trials: the number of stored trials.
        scores: what each cell's trials ended at, +inf for failed ones, by problem and optimizer.
        dimensions: the number of variables of each problem, as far as it is known.
        data: the hash of each problem's data.
        again: the trials that were made again.
    """

    name: str
    sha256: str
    study: Study
    records: tuple[Mapping[str, Any], ...]
    trials: int
    scores: Mapping[tuple[str, str], Floats]
    dimensions: Mapping[str, int]
    data: Mapping[str, str]
    again: tuple[Again, ...] = ()

    @property
    def settings(self) -> list[Setting]:
        """The settings of the study, one for each suite and dimension."""
        problems: dict[tuple[str, int], list[str]] = {}
        for entry in self.study.problems:
            if entry.label in self.dimensions:
                key = (family(entry.name), self.dimensions[entry.label])
                identity = [entry.label, entry.name, entry.options, self.data.get(entry.label, "")]
                problems.setdefault(key, []).append(json.dumps(identity, sort_keys=True, default=str))
        alone = self.name if self.study.imported else ""
        same = (self.study.constraints, tuple(self.study.looks), alone)
        return [
            Setting(suite, dimension, self.study.evaluations(dimension), tuple(sorted(members)), *same)
            for (suite, dimension), members in sorted(problems.items())
        ]

    @property
    def provenance(self) -> dict[str, str]:
        """The origin of the trials in words, for every row of a table; the seed of imported trials is unknown."""
        return {
            "seed": "unknown" if self.study.imported else str(self.study.seed), "versions": self.versions,
            "date": self.date, "made again": self.verified, "SHA-256": self.sha256,
        }  # fmt: skip

    @property
    def versions(self) -> str:
        """The versions of this harness and of Python that made the trials."""
        packages = (record.get("packages") for record in self.records)
        harness = _texts(versions.get(DISTRIBUTION) for versions in packages if isinstance(versions, Mapping))
        python = _texts(record.get("python") for record in self.records)
        return ", ".join(filter(None, (harness and f"bench {harness}", python and f"Python {python}"))) or "unknown"

    @property
    def date(self) -> str:
        """The day of the last run's end, or of its start where no end is noted."""
        times = (record.get("ended") or record.get("started") for record in self.records)
        return max((printable(str(time), 10).rstrip("…") for time in times if time), default="unknown")

    @property
    def verified(self) -> str:
        """How many trials of those chosen were the same when they were made again; "" where none was chosen."""
        if not self.again:
            return ""
        same = sum(not trial.different and not trial.reason for trial in self.again)
        differ = sum(bool(trial.different) for trial in self.again)
        reasons = sorted({trial.reason for trial in self.again if trial.reason})
        parts = [f"{same} of {len(self.again)}", f"{differ} differ" if differ else "", *reasons[:1]]
        return "; ".join(filter(None, parts))


def read(source: Path, temporary: Path) -> Archive:
    """Unpack an archive into a new folder, verify all of it, and return what the board needs.

    Raises:
        BenchError: naming the archive, where :func:`bench.formats.archive.unpack` refuses it.
    """
    unpack(source, temporary)
    folder = Folder(temporary)
    study = folder.study()
    dimensions = {entry.label: size for entry in study.problems if (size := dimension_in(entry.name))}
    cells: dict[tuple[str, str], list[float]] = {}
    for row in folder.store.rows(columns=("problem", "optimizer", "status", "fun", "variables")):
        fun = row["fun"]
        finished = row["status"] == "ok" and isinstance(fun, float | int) and math.isfinite(fun)
        cells.setdefault((row["problem"], row["optimizer"]), []).append(float(fun) if finished else math.inf)
        if row["problem"] not in dimensions and row["variables"]:
            dimensions[row["problem"]] = len(json.loads(row["variables"]))
    archive = Archive(
        printable(source.name, LONGEST), sha256_of(source), study, tuple(folder.environments()),
        sum(map(len, cells.values())),
        {cell: np.array(values) for cell, values in cells.items()}, dimensions, folder.data(),
    )  # fmt: skip
    try:
        _ = archive.settings
    except BenchError as error:
        raise BenchError(f"{source}: {error}") from error
    return archive


def refuse_twins(archives: Iterable[Archive]) -> None:
    """Raise BenchError where two archives have one name, or hold one study, whose trials would count twice."""
    names: dict[str, Archive] = {}
    studies: dict[str, Archive] = {}
    for archive in archives:
        if names.setdefault(archive.name.lower(), archive) is not archive:
            raise BenchError(f"two archives have the name {archive.name}; rename one of them")
        # The name of a study decides no trial, and an archive may hold it under another one.
        key = archive.sha256 if archive.study.imported else replace(archive.study, name="study").identity()
        first = studies.setdefault(key, archive)
        if first is not archive:
            raise BenchError(
                f"{first.name} and {archive.name} hold the same study with the same seed, so their trials would count "
                "twice; give one of them, or join their folders by 'bench merge'"
            )


def _texts(values: Iterable[object]) -> str:
    return ", ".join(sorted({printable(str(value), LONGEST) for value in values if value}))
