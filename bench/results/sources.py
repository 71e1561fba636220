"""The folders that results are read from: their studies, cells and environments, under distinct labels."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path

from bench.contract.families import dimension_in
from bench.helpers.errors import BenchError, nearest
from bench.helpers.parsing import JsonObject
from bench.helpers.text import unique
from bench.results.tidy import Tidy
from bench.storage.cells import Cells
from bench.storage.folder import Folder
from bench.storage.reading import READ, StoreCheck
from bench.study import Entry, Study
from bench.study.budget import Budget
from bench.study.cell import Labels, read

CELL = READ.index("cell")


@dataclasses.dataclass
class StudyFolder:
    """One folder with the labels as shown.

    Attributes:
        folder: the folder.
        name: its name, with as many parents as make it distinct.
        study: its study with the labels shown, and with earlier versions of optimizers that are asked for.
        shown: the label shown of each optimizer that the study in the folder names.
        cells: the labels of problem and optimizer that each cell is shown under, by its number in the store.
        versions: the number of its version, and the number of versions, of each optimizer with some that are not shown.
        environments: the records of the runs, by their numbers in the store.
        before: the number of those of the folders before.
    """

    folder: Folder
    name: str
    study: Study
    shown: dict[str, str]
    cells: dict[int, Labels]
    versions: dict[str, tuple[int, int]]
    environments: dict[int, JsonObject]
    before: int

    def by_label(self, noted: JsonObject) -> JsonObject:
        """Return a note of the folder on its optimizers, by the label shown."""
        return {self.shown[label]: each for label, each in noted.items() if label in self.shown}

    @property
    def planned(self) -> dict[str, int]:
        """The trials that each cell of an optimizer should hold, 0 of imported runs and of earlier versions."""
        planned = {*self.shown.values()} - {*self.study.imported}
        return {entry.label: self.study.trials * (entry.label in planned) for entry in self.study.optimizers}

    @property
    def budgets(self) -> dict[str, Budget]:
        """The budget of each optimizer by its label; for imported runs, the most that any of them spent.

        That is by dimension where the study's budget is. Where a run declared why it ended, it may have spent less than
        its budget, which is then taken for the study's.
        """
        whole = self.study.budget
        budgets = dict.fromkeys((entry.label for entry in self.study.optimizers), whole)
        if not self.study.imported:
            return budgets
        spent: dict[str, Counter[int | None]] = {}
        ended = set[str]()
        for cell in filter(lambda cell: cell.done, self.folder.store.cells(self.cells)):
            of_optimizer, dimension = spent.setdefault(cell.optimizer, Counter()), dimension_in(cell.problem)
            of_optimizer[dimension] = max(cell.most, of_optimizer[dimension], 1)
            ended |= {cell.optimizer} if cell.stops.keys() - {None, "budget", "undeclared"} else set()
        return budgets | {label: whole.spent(most_in) for label, most_in in spent.items() if label not in ended}

    def read(self, tidy: Tidy, shown: Mapping[int, Labels]) -> int:
        """Add the trials of cells, given with their labels, with environments' numbers of all folders.

        Return the number of all trials that are stored.

        Raises:
            BenchError: where any of them is not as it was written.
        """
        found = StoreCheck()
        self.folder.store.require()
        cells = {cell: (self.study.name, *labels) for cell, labels in shown.items()}
        places = {number: self.before + place for place, number in enumerate(self.environments, start=1)}
        with self.folder.store.reader() as reader:
            for rows in reader.chunks(found):
                if chosen := [row for row in rows if row[CELL] in cells]:
                    tidy.add(chosen, cells, reader.names, places)
        return self.folder.require(found).trials


def sources(folders: list[Folder], versions: Sequence[str]) -> list[StudyFolder]:
    """Read the folders' studies, cells and environments; make folder names and optimizer labels distinct."""
    studies = [folder.study() for folder in folders]
    names = _short_names([folder.path for folder in folders])
    labels = Counter(entry.label for study in studies for entry in study.optimizers)
    labelled = [
        f"{entry.label} ({name})" if labels[entry.label] > 1 else entry.label
        for study, name in zip(studies, names, strict=True)
        for entry in study.optimizers
    ]
    distinct = iter(unique(labelled))  # a label may already equal another one with its folder
    found: list[StudyFolder] = []
    before = 0
    for folder, study, name in zip(folders, studies, names, strict=True):
        shown = {entry.label: next(distinct) for entry in study.optimizers}
        held = folder.store.held()
        older, cells, numbers = _versions(held, shown, versions)
        cells |= {n: (problem, shown[label]) for n, (problem, label) in held.selected.items() if label in shown}
        optimizers = (dataclasses.replace(entry, label=shown[entry.label]) for entry in study.optimizers)
        environments = folder.store.records("environments")
        subject = shown.get(study.subject, study.subject) if len(folders) == 1 else study.subject
        renamed = dataclasses.replace(study, optimizers=(*older, *optimizers), subject=subject)
        found.append(StudyFolder(folder, name, renamed, shown, cells, numbers, environments, before))
        before += len(environments)
    return found


def _versions(
    held: Cells, shown: dict[str, str], wanted: Sequence[str]
) -> tuple[list[Entry], dict[int, Labels], dict[str, tuple[int, int]]]:
    """Return earlier versions of optimizers as entries, their cells, and the numbers of versions that stand alone.

    A version has its number behind its label, the one that the study selects too, which ``shown`` gets. Only trials
    under the conditions of the selected ones are comparable: on the same problems, from one seed and of one budget.

    Raises:
        BenchError: where an optimizer of which versions are wanted has none.
    """
    matched = {label for label in shown for pattern in wanted if fnmatchcase(label, pattern)}
    if unmatched := [pattern for pattern in wanted if not any(fnmatchcase(label, pattern) for label in shown)]:
        raise BenchError(f"no optimizer is called {unmatched[0]!r}{nearest(unmatched[0], shown)}")
    entries: list[Entry] = []
    cells: dict[int, Labels] = {}
    numbers: dict[str, tuple[int, int]] = {}
    problems = {(cell.problem, cell.conditions): labels[0] for labels, cell in held.by_labels.items()}
    records, every = held.optimizers, held.versions
    for label, name in [*shown.items()]:
        selected, before = records.get(label, ""), len(entries)
        versions = every[read(selected)["label"]] if selected else {}
        if label not in matched:
            if len(versions) > 1:
                numbers[name] = [*versions].index(selected) + 1, len(versions)
            continue
        for place, (record, of) in enumerate(versions.items(), start=1):
            run = {number: held.all[number] for number in of if held.trials[number]}
            if record == selected:
                shown[label] = f"{name}@{place}"
            elif run:
                about = read(record)
                entries.append(Entry(about["name"], f"{name}@{place}", about["options"]))
                alike = {number: problems.get((cell.problem, cell.conditions)) for number, cell in run.items()}
                cells |= {number: (problem, f"{name}@{place}") for number, problem in alike.items() if problem}
        if len(entries) == before:
            raise BenchError(f"{label!r} has one version in the folder, so there is none to show beside it")
    return entries, cells, numbers


def _short_names(paths: list[Path]) -> list[str]:
    """Return the folders' names, with as many parents as make them distinct."""
    parts = [path.resolve().parts for path in paths]
    if len(set(parts)) < len(parts):
        raise BenchError(f"{paths[0]} is given twice; give folders that differ")
    for depth in range(1, max(map(len, parts)) + 1):
        names = ["/".join(path_parts[-depth:]) for path_parts in parts]
        if len(set(names)) == len(names):
            break
    return ["".join(c if c.isprintable() else "?" for c in name) for name in names]
