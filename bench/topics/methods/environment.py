"""The machines and versions that made the trials, and the trials that each of them made."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import pandas as pd

from bench.helpers.parsing import JsonObject
from bench.helpers.text import listed
from bench.plugins.inputs import shown
from bench.report.parts import File, Line, Table, warning
from bench.report.wording import count, listing, options
from bench.results.results import StoredResults
from bench.storage.provenance import differences

NAMED = 3  # environments that the warning compares with the first; the files have all
FIRST = ("processor", "cores", "memory", "system", "Python", "BLAS", "commit")  # items that the page shows
RUN = {
    "folder": "folder", "imported": "imported from", "format": "format", "sha256": "SHA-256", "licence": "licence",
    "started": "started", "ended": "ended", "host": "machine", "jobs": "jobs", "backend": "backend",
    "timeout": "timeout s", "shard": "shard", "command": "command",
}  # fmt: skip
"""The titles of what a record says of its run."""


@dataclass(frozen=True)
class Environments:
    """The records of the runs, grouped into environments A, B and so on where alike, and the trials of each run."""

    results: StoredResults

    @property
    def records(self) -> Sequence[JsonObject]:
        """What each run recorded on each machine."""
        return self.results.environments

    @property
    def numbers(self) -> pd.Series[int]:
        """The record that each trial belongs to, counted from 1."""
        return self.results.origins

    @cached_property
    def groups(self) -> dict[str, list[int]]:
        """The positions of the records that are alike, by letter."""
        places_of: dict[str, list[int]] = {}
        for place, record in enumerate(self.records):
            alike = (letter for letter, group in places_of.items() if not differences(self.records[group[0]], record))
            places_of.setdefault(next(alike, _letter(len(places_of))), []).append(place)
        return places_of

    @cached_property
    def letters(self) -> dict[int, str]:
        """The letter of each record's environment, by its number."""
        return {place + 1: letter for letter, group in self.groups.items() for place in group}

    def warnings(self) -> Iterator[Line]:
        """Yield lines on what changed since, what an import left out, and trials of several environments."""
        for label, names in self.results.changed.items():
            what = listing(list(map(shown, names)), at_most=5)
            text = f"{label} changed since its trials were made ({what}); the report is of what it was."
            yield warning("changed since its trials were made", text)
        if not self.records:
            yield warning("machine not known", "The folder has no record of the machine that ran it.")
        for record in self.records:
            if lost := record.get("left_out"):
                text = f"The import of {record['imported']} left out what cannot be read: {listed(lost, between='; ')}."
                yield warning("left out by the import", text)
        made = set(self.numbers.dropna())
        used = [letter for letter, group in self.groups.items() if not made or made & {place + 1 for place in group}]
        if len(used) < 2:
            return
        first, *others = ((letter, self.records[self.groups[letter][0]]) for letter in used)
        changes = "; ".join(
            f"{letter} differs from {first[0]} by {listing(differences(first[1], record), at_most=5)}"
            for letter, record in others[:NAMED]
        )
        rest = f"; and {len(others) - NAMED} more" if len(others) > NAMED else ""
        text = f"The trials come from {len(used)} different environments; compare times with care. {changes}{rest}."
        yield warning("several environments", text)

    def table(self) -> Table:
        """Return the table of the environments, a column each; the file has every item and all of them."""
        loaded = {f"package {name}": version for name, version in self.results.packages.items()}
        every = pd.DataFrame({letter: self._items(group) | loaded for letter, group in self.groups.items()})
        shown = every.loc[[item for item in FIRST if item in every.index]].iloc[:, : NAMED + 1]
        shown = shown.set_axis(["value"], axis=1) if every.shape[1] == 1 else shown
        return Table(
            "environment",
            "The machine and the versions that made the trials.",
            shown.rename_axis("item"),
            note="The CSV file has the version of every package.",
            data=every.rename_axis("item").reset_index(),
        )

    def files(self) -> Iterator[File]:
        """Yield the files of the runs, of the trials that each made, of entries and of data."""
        yield File(
            "tables/environment-runs.csv",
            "The runs, a row for each machine that took part; times are in UTC.",
            self._runs(),
        )
        if self.numbers.notna().any():
            rows = self.results.frame[["problem", "optimizer", "trial"]].assign(
                run=self.numbers, environment=self.numbers.map(self.letters).fillna("not recorded")
            )
            yield File("tables/environment-trials.csv", "The run and the environment of every trial.", rows)
        yield File("tables/entries.csv", "The options that the study sets; others are the defaults.", self._entries())
        data = [(label, file, state) for label, files in self.results.data.items() for file, state in files.items()]
        if data:
            hashes = pd.DataFrame(data, columns=["problem", "file", "SHA-256"])
            yield File("tables/data.csv", "The files of data that trials were made from, each with its hash.", hashes)

    def _items(self, group: list[int]) -> dict[str, str]:
        """Return the items of an environment; machines of one environment may differ, for example in cores."""
        table = pd.DataFrame([_items(self.records[place]) for place in group])
        return {str(item): listing(list(values.dropna().unique()), at_most=4) for item, values in table.items()}

    def _runs(self) -> pd.DataFrame:
        rows = [
            {
                "run": number,
                "environment": self.letters[number],
                "trials": int((self.numbers == number).sum()),
                **{title: _text(record.get(key), key) for key, title in RUN.items()},
            }
            for number, record in enumerate(self.records, start=1)
        ]
        return pd.DataFrame(rows).dropna(axis=1, how="all")

    def _entries(self) -> pd.DataFrame:
        study = self.results.study
        return pd.DataFrame(
            [
                {"kind": kind, "label": entry.label, "plug-in": entry.name, "options": options(entry.options)}
                for kind, group in (("optimizer", study.optimizers), ("problem", study.problems))
                for entry in group
            ]
        )


def _letter(number: int) -> str:
    """Return A to Z, then AA, AB and so on."""
    return (_letter(number // 26 - 1) if number >= 26 else "") + chr(ord("A") + number % 26)


def _items(record: JsonObject) -> dict[str, str]:
    """Return machine, versions and code of a record, by name."""
    memory = record.get("memory_gb")
    items = {
        "processor": record.get("processor"),
        "cores": record.get("cores"),
        "memory": f"{memory} GB" if memory else None,
        "system": record.get("system"),
        "Python": record.get("python"),
        "BLAS": "; ".join(_blas(library) for library in record.get("blas") or ()),
        "commit": _state(record.get("git")),
        "harness": record.get("harness"),
        **{f"package {name}": version for name, version in (record.get("packages") or {}).items()},
    }
    return {item: str(value) for item, value in items.items() if value}


def _blas(noted: JsonObject) -> str:
    threads = noted.get("threads")
    return f"{noted.get('library')} {noted.get('version')}" + (f", {count(threads, 'thread')}" if threads else "")


def _state(git: JsonObject | None) -> str:
    """Return a commit, and whether there were uncommitted changes."""
    return f"{git.get('commit')}" + " with uncommitted changes" * bool(git.get("dirty")) if git else ""


def _text(value: object, key: str) -> str | None:
    """Return a value of a record as text, times without their zone; None where it is missing."""
    if value is None:
        return None
    return str(value).removesuffix("+00:00").replace("T", " ") if key in ("started", "ended") else str(value)
