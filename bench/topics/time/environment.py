"""List data, seeds, machines and versions, and the trials that each of them produced."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import pandas as pd

from bench.helpers.text import listed
from bench.plugins.inputs import shown
from bench.report.parts import Section, Table
from bench.report.wording import count, listing, options
from bench.results.results import StoredResults
from bench.storage.provenance import differences
from bench.study import Study
from bench.topics.findings import Findings

TITLE = "Environment, seeds and data"
NAMED = 3  # environments that the warning compares with the first; the table has all
COLUMNS = 12  # environments with a column of their own; the others share one


def section(findings: Findings) -> Section:
    """Return the entries with their options, the hashes of study and data, the runs and their environments."""
    results = findings.results
    instance = " with its instance" if findings.trials.precisions else ""
    seeds = (
        f"The seed of the study is {results.study.seed}. The seed of a trial is a hash of the study’s seed, the "
        f"problem{instance}, the optimizer and the trial’s number; trials.csv lists it. bench.solve with that seed and "
        "the same options and budget repeats the trial."
    )
    text = [seeds]
    if len(results.names) == 1:
        text.append(
            f"The hash of everything that determines the result of a trial is {results.whole.identity()}; it does not "
            "depend on the number of trials or the title."
        )
    items = [_entries(results.study)]
    if data := [(label, file, state) for label, files in results.data.items() for file, state in files.items()]:
        hashes = pd.DataFrame(data, columns=["problem", "file", "SHA-256"]).set_index("problem")
        items.append(Table("data", "The files of data that trials were made from, each with its hash.", hashes))
    if not results.environments:
        return Section(TITLE, tuple(text), tuple(items), ("The folder has no record of the machine that ran it.",))
    origins = _Origins(results.environments, results.frame, results.origins)
    items += [*origins.environments(), origins.runs()]
    if origins.known and len(origins.groups) > 1:
        items.append(origins.trials())
    return Section(TITLE, tuple(text), tuple(items), (*_changed(results), *origins.warnings()), on_demand=True)


def _changed(results: StoredResults) -> Iterator[str]:
    """Yield a sentence for each problem or optimizer that is another one by now than that of the trials."""
    for label, names in results.changed.items():
        what = listing(list(map(shown, names)), at_most=5)
        yield f"{label} changed since its trials were made ({what}); the report is of what it was."


def _entries(study: Study) -> Table:
    entries = pd.DataFrame(
        [
            {"kind": kind, "label": entry.label, "plug-in": entry.name, "options": options(entry.options)}
            for kind, group in (("optimizer", study.optimizers), ("problem", study.problems))
            for entry in group
            if kind == "optimizer" or entry.options or entry.label != entry.name  # the label says all of the others
        ]
    )
    return Table(
        "entries",
        "The optimizers, and the problems with options or a label of their own, with the options that the study sets; "
        "all others are the defaults.",
        entries,
    )


@dataclass(frozen=True)
class _Origins:
    """The records of the runs, grouped into environments A, B and so on where alike, and the trials of each run."""

    records: Sequence[Mapping[str, Any]]  # what each run recorded on each machine
    frame: pd.DataFrame
    numbers: pd.Series[Any]  # the record that each trial belongs to, counted from 1

    @property
    def known(self) -> bool:
        """Whether any trial names its run."""
        return bool(self.numbers.notna().any())

    @cached_property
    def made(self) -> list[int]:
        """How many trials each run made."""
        return [int((self.numbers == number).sum()) for number in range(1, len(self.records) + 1)]

    @cached_property
    def groups(self) -> dict[str, list[int]]:
        """The positions of the records that are alike, by letter."""
        places_of: dict[str, list[int]] = {}
        for place, record in enumerate(self.records):
            alike = (letter for letter, group in places_of.items() if not differences(self.records[group[0]], record))
            places_of.setdefault(next(alike, _letter(len(places_of))), []).append(place)
        return places_of

    @cached_property
    def letters(self) -> list[str]:
        """The letter of each record's environment."""
        letter_of = {place: letter for letter, group in self.groups.items() for place in group}
        return [letter_of[place] for place in sorted(letter_of)]

    def warnings(self) -> Iterator[str]:
        """Yield a warning on what an import left out, and where trials, or their runs, are of several environments."""
        for record in self.records:
            if lost := record.get("left_out"):
                yield f"The import of {record['imported']} left out what cannot be read: {listed(lost, between='; ')}."
        used = [letter for letter, group in self.groups.items() if not self.known or any(self.made[i] for i in group)]
        if len(used) < 2:
            return
        first, *others = ((letter, self.records[self.groups[letter][0]]) for letter in used)
        changes = "; ".join(
            f"{letter} differs from {first[0]} by {listing(differences(first[1], record), at_most=5)}"
            for letter, record in others[:NAMED]
        )
        rest = f"; and {len(others) - NAMED} more" if len(others) > NAMED else ""
        yield f"The trials come from {len(used)} different environments; compare times with care. {changes}{rest}."

    def environments(self) -> Iterator[Table]:
        """Yield a table of the items that all environments share, and one of the items that differ."""
        about = pd.DataFrame({letter: self._items(group) for letter, group in self.groups.items()}).T
        shared = [item for item in about if about[item].nunique(dropna=False) == 1]
        if shared:
            several = len(self.groups) > 1
            caption = "What all environments have in common." if several else "The environment of all trials."
            frame = about[shared].iloc[:1].T.set_axis(["value"], axis=1).rename_axis("item")
            yield Table("environment", caption, frame)
        if len(self.groups) > 1:
            apart = about.drop(columns=shared).rename_axis("environment")
            yield Table("environments", "How the environments differ.", apart)

    def _items(self, group: list[int]) -> dict[str, str]:
        """Return the items of an environment; machines of one environment may differ, for example in cores."""
        table = pd.DataFrame([_items(self.records[place]) for place in group])
        return {str(item): listing(list(values.dropna().unique()), at_most=4) for item, values in table.items()}

    def runs(self) -> Table:
        """Return a table of every run on every machine that took part."""
        columns: dict[str, Any] = {}
        if len(self.groups) > 1:
            columns["environment"] = self.letters
        if self.known:
            columns["trials"] = self.made
        names = {
            "folder": "folder", "imported": "imported from", "format": "format", "sha256": "SHA-256",
            "licence": "licence", "started": "started", "ended": "ended", "host": "machine", "jobs": "jobs",
            "backend": "backend", "timeout": "timeout s", "shard": "shard", "command": "command",
        }  # fmt: skip
        for key, title in names.items():
            columns[title] = [_text(record.get(key), key) for record in self.records]
        frame = pd.DataFrame(columns, index=pd.RangeIndex(1, len(self.records) + 1, name="run"))
        caption = "The runs, one row for each machine that took part, with the options given; times are in UTC."
        return Table("runs", caption, frame.dropna(axis=1, how="all"))

    def trials(self) -> Table:
        """Return a table of the number of trials of each optimizer from each environment."""
        rows = self.frame[["problem", "optimizer", "trial"]].assign(
            run=self.numbers,
            environment=self.numbers.map(dict(enumerate(self.letters, start=1))).fillna("not recorded"),
        )
        counts = pd.crosstab(rows["optimizer"], rows["environment"]).rename_axis(columns=None)
        letters = [letter for letter in [*self.groups, "not recorded"] if letter in counts]
        shown = counts.loc[rows["optimizer"].unique(), letters]
        if len(letters) > COLUMNS:
            shown = shown.iloc[:, : COLUMNS - 1].assign(others=shown.iloc[:, COLUMNS - 1 :].sum(axis=1))
        caption = "Number of trials of each optimizer from each environment."
        note = "The CSV file has the run and the environment of every trial."
        return Table("environment-trials", caption, shown, note=note, data=rows)


def _letter(number: int) -> str:
    """Return A to Z, then AA, AB and so on."""
    return (_letter(number // 26 - 1) if number >= 26 else "") + chr(ord("A") + number % 26)


def _items(record: Mapping[str, Any]) -> dict[str, str]:
    """Return machine, versions and code of a record, by name."""
    memory = record.get("memory_gb")
    items = {
        "processor": record.get("processor"),
        "cores": record.get("cores"),
        "memory": f"{memory} GB" if memory else None,
        "system": record.get("system"),
        "Python": record.get("python"),
        "BLAS": "; ".join(_blas(library) for library in record.get("blas") or ()),
        **{f"package {name}": version for name, version in (record.get("packages") or {}).items()},
        "commit": _state(record.get("git")),
        **{f"commit of {name}": _state(git) for name, git in (record.get("checkouts") or {}).items()},
    }
    return {item: str(value) for item, value in items.items() if value}


def _blas(noted: Mapping[str, Any]) -> str:
    threads = noted.get("threads")
    return f"{noted.get('library')} {noted.get('version')}" + (f", {count(threads, 'thread')}" if threads else "")


def _state(git: Mapping[str, Any] | None) -> str:
    """Return a commit, and whether there were uncommitted changes, with their hash."""
    if not git:
        return ""
    if not git.get("dirty"):
        return str(git.get("commit"))
    return f"{git.get('commit')} with uncommitted changes" + (f" ({git['diff'][:12]})" if git.get("diff") else "")


def _text(value: Any, key: str) -> str | None:
    """Return a value of a record as text, times without their zone; None where it is missing."""
    if value is None:
        return None
    return str(value).removesuffix("+00:00").replace("T", " ") if key in ("started", "ended") else str(value)
