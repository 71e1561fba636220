"""Find the cells of a study in a store, name those that have changed, and explain the difference in words."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field

from bench.helpers.errors import BenchError
from bench.helpers.text import count, listed
from bench.plugins.inputs import Present, shown
from bench.storage.cells import Cells
from bench.study.cell import Cell, Labels, alike, differences, read, relabelled

KINDS = "problem", "optimizer"


@dataclass(frozen=True)
class Selection:
    """The cells of a study, as a store has them or will have them.

    Attributes:
        cells: by the labels that the study shows. The labels in a cell are those that its seeds are made from: an entry
            that was renamed keeps its trials.
        notes: sentences on what changed since the study that ran here before.
    """

    cells: dict[Labels, Cell]
    notes: list[str] = field(default_factory=list)

    @property
    def seeds(self) -> dict[Labels, Labels]:
        """The labels that seeds are made from, by the labels shown."""
        return {labels: cell.labels for labels, cell in self.cells.items()}

    def labels_in(self, held: Cells) -> dict[int, Labels]:
        """Return the labels of the selected cells that a store holds, by their number in it."""
        known = {cell: number for number, cell in held.all.items()}
        return {known[cell]: labels for labels, cell in self.cells.items() if cell in known}


def select(wanted: Mapping[Labels, Cell], most: int, held: Cells, present: Present) -> Selection:
    """Return the selection of a study's cells from a store that holds some of them.

    Args:
        wanted: the study's cells by the labels that it shows, with these labels in them.
        most: the number of trials that each is to have.
        held: the cells of the store.
        present: what trials would be made from now.

    Raises:
        BenchError: where a new label may stand for cells of two labels.
    """
    renamed = [_seed_labels(place, wanted, held) for place in range(2)]
    stored = held.stored
    run = {text for cell in stored for text in cell.records}
    now = [
        {
            label: _present(place, relabelled(cell.records[place], renamed[place][label]), label, held, run, present)
            for label, cell in {labels[place]: cell for labels, cell in wanted.items()}.items()
        }
        for place in range(2)
    ]
    named = {labels: Cell(now[0][labels[0]], now[1][labels[1]], *cell.conditions) for labels, cell in wanted.items()}
    return Selection(named, [*_Changes(held.by_labels, named, most, held, stored, present).notes()])


def _present(place: int, bare: str, label: str, held: Cells, run: Collection[str], present: Present) -> str:
    """Return the record of which the trials were made from what is there now; of new inputs where there is none."""
    latest, *others = held.candidates(place, bare)
    unchanged = (
        text
        for text in (latest, *others[:-1])
        if (not present.changed(held.made.get(text, {}), label) if text in run else text == latest)
    )
    return next(unchanged, [latest, *others][-1])


def _seed_labels(place: int, wanted: Mapping[Labels, Cell], held: Cells) -> dict[str, str]:
    """Return the label that seeds are made from for each label shown, of problems (0) or optimizers (1).

    It is that under which the entry was run here before, or that of an equal entry which the study no longer names.
    """
    now = {labels[place]: cell.records[place] for labels, cell in wanted.items()}
    before = {labels[place]: cell.labels[place] for labels, cell in held.by_labels.items()}
    records = {text: str(read(text)["label"]) for text in {cell.records[place] for cell in held.stored}}
    chosen = {}
    for label in now.keys() & {*before, *records.values()}:
        seed = before.get(label, label)
        chosen[label] = seed if seed not in now else label
    for label, text in now.items():
        if label not in chosen:
            taken = {*chosen.values(), *now}
            twins = sorted({twin for other, twin in records.items() if twin not in taken and alike(other, text)})
            if len(twins) > 1:
                raise BenchError(
                    f"the {KINDS[place]} {label!r} is new to the folder, and may be {listed(list(map(repr, twins)))}, "
                    "which the study no longer names; give it the label of the one that it is"
                )
            chosen[label] = twins[0] if twins else label
    return chosen


@dataclass(frozen=True)
class _Changes:
    """The changes since the study that ran in a folder before."""

    before: Mapping[Labels, Cell]
    now: Mapping[Labels, Cell]
    most: int
    held: Cells
    stored: Counter[Cell]
    present: Present

    def notes(self) -> Iterator[str]:
        """Yield a sentence, without a full stop, for each change of which a reader of the plan must know."""
        same = [labels for labels in self.now if labels in self.before]
        different = [labels for labels in same if self.now[labels].conditions != self.before[labels].conditions]
        if different:
            yield f"{listed([*self._conditions(different)])}: {self._numbers(different, 'before')}"
        for place, kind in enumerate(KINDS):
            yield from self._of(place, kind, [labels for labels in same if labels not in different])

    def _conditions(self, different: Collection[Labels]) -> Iterator[str]:
        for key in ("evaluations", "seed"):
            pairs = {(getattr(self.before[labels], key), getattr(self.now[labels], key)) for labels in different}
            if changed := [pair for pair in pairs if pair[0] != pair[1]]:
                yield f"{key} changed" + (f" from {changed[0][0]:,} to {changed[0][1]:,}" if len(changed) == 1 else "")

    def _of(self, place: int, kind: str, same: Collection[Labels]) -> Iterator[str]:
        groups: dict[str, list[Labels]] = {}
        for labels in same:
            groups.setdefault(labels[place], []).append(labels)
        for label, cells in groups.items():
            old, new = self.before[cells[0]], self.now[cells[0]]
            if old.records[place] != new.records[place]:
                which = f"of {self._version(old)}" if place else "before"
                yield f"{label} {self._change(place, label, old, new)}: {self._numbers(cells, which)}"
        shown = {labels[place] for labels in self.now}
        seeds = {cell.labels[place]: labels for labels, cell in self.now.items()}
        for label in dict.fromkeys(labels[place] for labels in self.before if labels[place] not in shown):
            gone = [cell for labels, cell in self.before.items() if labels[place] == label]
            kept = count(sum(self.stored[cell] for cell in gone), "trial")
            renamed = seeds.get(gone[0].labels[place])
            if renamed is None:
                yield f"the {kind} {label} is no longer in the study: its {kept} are kept"
            elif self.now[renamed].records[place] == gone[0].records[place]:
                yield f"the {kind} {label} is called {renamed[place]} now, and keeps its {kept}"
            else:
                changed = self._change(place, renamed[place], gone[0], self.now[renamed])
                yield f"the {kind} {label} is called {renamed[place]} now, and {changed}: its {kept} are kept"

    def _change(self, place: int, label: str, old: Cell, new: Cell) -> str:
        """Return how a problem or an optimizer changed, and which version it is by now."""
        before = old.records[place]
        names = self.present.changed(self.held.made.get(before, {}), label)
        how = "; ".join([*dict.fromkeys(map(shown, names)), *differences(before, new.records[place])])
        how = how or "its label was that of another one"
        return f"changed ({how})" + (f" and is {self._version(new)} now" if place else "")

    def _version(self, cell: Cell) -> str:
        """Return the number of the version of its optimizer that a cell has."""
        versions = [*self.held.versions.get(read(cell.optimizer)["label"], ()), cell.optimizer]
        return f"version {versions.index(cell.optimizer) + 1}"

    def _numbers(self, cells: Collection[Labels], which: str) -> str:
        left = sum(max(self.most - self.stored[self.now[labels]], 0) for labels in cells)
        kept = sum(self.stored[self.before[labels]] for labels in cells)
        return f"{count(left, 'trial')} to make; the {kept:,} {which} are kept"
