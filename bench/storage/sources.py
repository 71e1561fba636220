"""Combine several folders into one study: distinct folder names and optimizer labels, equal budgets and data."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from bench.errors import BenchError
from bench.storage.folder import Folder
from bench.study import Entry, Study
from bench.text import unique


@dataclasses.dataclass(frozen=True)
class Source:
    """One folder: its study with the labels as shown, the shown label of each optimizer, and its environments."""

    folder: Folder
    name: str
    study: Study
    shown: dict[str, str]
    environments: list[dict[str, Any]]
    environment_places: dict[int, int]

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield the store's rows with shown labels, the study's name and the environment's number among all folders."""
        known = {entry.label for entry in self.study.problems}
        for row in self.folder.store.rows():
            if row["problem"] not in known or row["optimizer"] not in self.shown:
                strange = row["optimizer"] if row["problem"] in known else row["problem"]
                raise BenchError(
                    f"{self.folder.path} holds trials of {strange!r}, which its study.toml does not name; "
                    "put back the study.toml that the run wrote"
                )
            place = self.environment_places.get(row["environment"])
            yield row | {"study": self.study.name, "optimizer": self.shown[row["optimizer"]], "environment": place}


def read_sources(folders: list[Folder]) -> list[Source]:
    """Read the folders' studies and environments; make folder names and optimizer labels distinct."""
    studies = [folder.study() for folder in folders]
    names = _short_names([folder.path for folder in folders])
    labels = Counter(entry.label for study in studies for entry in study.optimizers)
    every = [
        f"{entry.label} ({name})" if labels[entry.label] > 1 else entry.label
        for study, name in zip(studies, names, strict=True)
        for entry in study.optimizers
    ]
    distinct = iter(unique(every))  # a label may already equal another one with its folder
    sources: list[Source] = []
    for folder, study, name in zip(folders, studies, names, strict=True):
        shown = {entry.label: next(distinct) for entry in study.optimizers}
        optimizers = tuple(dataclasses.replace(entry, label=shown[entry.label]) for entry in study.optimizers)
        noted = folder.store.environments()
        environments = [{"folder": name} | record if len(folders) > 1 else record for record in noted.values()]
        before = sum(len(source.environments) for source in sources)
        places = {number: before + place for place, number in enumerate(noted, start=1)}
        own = dataclasses.replace(study, optimizers=optimizers)
        sources.append(Source(folder, name, own, shown, environments, places))
    return sources


def _short_names(paths: list[Path]) -> list[str]:
    """Return the folders' names, with as many parents as make them distinct."""
    parts = [path.resolve().parts for path in paths]
    if len(set(parts)) < len(parts):
        raise BenchError(f"{paths[0]} is given twice; give folders that differ")
    for depth in range(1, max(map(len, parts)) + 1):
        names = ["/".join(each[-depth:]) for each in parts]
        if len(set(names)) == len(names):
            break
    return ["".join(c if c.isprintable() else "?" for c in name) for name in names]


def united(studies: list[Study]) -> Study:
    """Return one study with the problems and optimizers of all."""
    first = studies[0]
    if len(studies) == 1:
        return first
    problems: dict[str, Entry] = {}
    for study in studies:
        if study.budget != first.budget:
            raise BenchError(
                f"study {first.name!r} has a budget of {first.budget:,} evaluations and {study.name!r} one of "
                f"{study.budget:,}; only runs of one budget can be compared"
            )
        for entry in study.problems:
            if problems.setdefault(entry.label, entry) != entry:
                raise BenchError(
                    f"problem {entry.label!r} has other options in {study.name!r} than in the studies before it; "
                    "only runs on the same problem can be compared"
                )
    return dataclasses.replace(
        first,
        name="-".join(dict.fromkeys(study.name for study in studies)),
        title=" beside ".join(dict.fromkeys(study.title or study.name for study in studies)),
        trials=max(study.trials for study in studies),
        problems=tuple(problems.values()),
        optimizers=tuple(entry for study in studies for entry in study.optimizers),
    )


def agreed(fingerprints: Sequence[dict[str, str]], paths: list[Path]) -> dict[str, str]:
    """Return the fingerprints of all folders; raises BenchError when a problem's data differs between folders."""
    agreed: dict[str, str] = {}
    for each, path in zip(fingerprints, paths, strict=True):
        for label, fingerprint in each.items():
            if agreed.setdefault(label, fingerprint) != fingerprint:
                raise BenchError(
                    f"{path} ran problem {label!r} on other data than {paths[0]}; only runs on the same data can be "
                    "compared"
                )
    return agreed
