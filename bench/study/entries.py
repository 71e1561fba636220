"""The entries of a study: problems and optimizers that its tables select, with their labels and options."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from bench.contract.typing import Options
from bench.helpers.errors import BenchError
from bench.helpers.parsing import Json, JsonObject
from bench.helpers.text import is_formula
from bench.plugins import loading, objects, selection
from bench.study.initial import known_points
from bench.study.sweep import expanded

LONGEST_LABEL = 200
"""Characters of the label of a problem or an optimizer."""


@dataclass(frozen=True)
class Entry:
    """A problem or an optimizer of a study: its plug-in name, its label in results, and its options.

    ``files`` are read by it where nobody sees that, as by a program; their names may hold ``*``. The option
    ``initial`` of a problem are the points that are known before a search.
    """

    name: str
    label: str
    options: Options = field(default_factory=dict)
    files: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Turn tuples among the options into lists, as a study's file holds them."""
        object.__setattr__(self, "options", _as_lists(self.options))

    def as_dict(self) -> JsonObject:
        """Return the entry as a table of a study file."""
        label = {} if self.label == self.name else {"label": self.label}
        files = {"files": [*self.files]} if self.files else {}
        return {"name": self.name, **label, **self.options, **files}


def read_entries(items: object, key: str, where: str) -> tuple[Entry, ...]:
    """Return the entries of a ``[[problems]]`` or ``[[optimizers]]`` list, in which a text is a table with that name.

    In place of a name a dict from Python may have a problem or an optimizer itself (:mod:`bench.plugins.objects`).
    ``names`` gives one entry for each name, a pattern one for each name that matches, and ``suite`` one for each
    problem that is selected from the suite; ``{name}`` in a label stands for the entry's name. Lists in the table
    ``options`` of optimizers give one entry for each combination of their values; everywhere else a list is a value.
    """
    if not (isinstance(items, list) and items) or not all(
        isinstance(item, dict | str) or loading.is_plugin(item) for item in items
    ):
        raise BenchError(f"study {where} needs at least one [[{key}]] table with a name, or a list of names as {key}")
    entries: list[Entry] = []
    for item in items:
        options = dict(item) if isinstance(item, dict) else {"name": item}
        if len({"name", "names", "suite", "problem"} & options.keys()) > 1:
            raise BenchError(f"study {where}: a [[{key}]] table has one of name, names, suite and problem")
        if key == "problems" and "problem" in options:
            options["name"] = _command("problem", options.pop("problem"), where)
        if key == "problems" and "suite" in options:
            options["names"] = selection.selected(*(options.pop(part, None) for part in selection.KEYS))
        names = options.pop("names") if "names" in options else [options.pop("name", None)]
        label, files = options.pop("label", None), options.pop("files", [])
        if not (isinstance(files, list) and all(isinstance(file, str) and file for file in files)):
            raise BenchError(f"study {where}: 'files' of a [[{key}]] table must be a list of files, not {files!r}")
        if key == "problems" and "initial" in options:
            options["initial"] = known_points(options["initial"], where)
        if key == "optimizers" and names == ["command"]:
            names = [_command("command", options.pop("command", None), where)]
        if isinstance(names, list) and len(names) == 1 and loading.is_plugin(names[0]):
            kind = "problems" if key == "problems" else "optimizers"
            held = [entry.name for entry in entries if loading.is_object(entry.name)]
            name, label, chosen = objects.hold(kind, names[0], label, held)
            names, options = [name], chosen | options
        swept = {} if key == "problems" else _swept(options, where)
        texts = isinstance(names, list) and names and all(isinstance(name, str) and name.strip() for name in names)
        if not texts or not (label is None or (isinstance(label, str) and label.strip())):
            raise BenchError(f"study {where}: a [[{key}]] table needs a name (or a list of names), all of them texts")
        expand = selection.matching if key == "problems" else loading.matching
        names = [match for name in names for match in expand(name)]
        for name in names:
            combinations = expanded((label or loading.default_label(name)).replace("{name}", name), options, swept)
            entries += [Entry(name, *combination, tuple(files)) for combination in combinations]
    check_labels(entries, key, where)
    return tuple(entries)


def check_labels(entries: Iterable[Entry], key: str, where: str) -> None:
    """Raise BenchError where a label of problems or optimizers cannot be shown, or two entries have one."""
    labels = [entry.label for entry in entries]
    if not all(label.isprintable() for label in labels):
        raise BenchError(f"study {where}: a label of the {key} holds a control character or a line break")
    if formulas := [label for label in labels if is_formula(label)]:
        raise BenchError(
            f"study {where}: a spreadsheet would compute the label {formulas[0][:40]!r} of the {key} as a formula; "
            "give the table another 'label'"
        )
    if long := [label for label in labels if len(label) > LONGEST_LABEL]:
        raise BenchError(
            f"study {where}: the label {long[0][:40]!r}… of the {key} has {len(long[0]):,} characters, more than "
            f"{LONGEST_LABEL}; give the table a shorter 'label'"
        )
    if twice := sorted(label for label, count in Counter(labels).items() if count > 1):
        raise BenchError(f"study {where}: {twice[0]!r} occurs twice among the {key}; give one of them another label")


def _command(key: str, words: object, where: str) -> str:
    """Return the name of a plug-in that is a program, from the words of its command."""
    if not isinstance(words, list) or not words or not all(isinstance(word, str) and word for word in words):
        raise BenchError(
            f'study {where}: a program needs the words of its command as {key!r}, as in {key} = ["Rscript", "mine.R"]'
        )
    return f"command:{shlex.join(words)}"


def _swept(options: Options, where: str) -> Options:
    """Take the table ``options`` out of an optimizer's keys and return it; empty where there is none."""
    values = options.pop("options", {})
    if not isinstance(values, dict):
        raise BenchError(f"study {where}: 'options' of an optimizer must be a table, not {values!r}")
    if twice := sorted(values.keys() & options.keys()):
        raise BenchError(f"study {where}: {twice[0]!r} is given twice, in 'options' and beside it; leave one out")
    if reserved := sorted(values.keys() & {"name", "names", "label"}):
        raise BenchError(f"study {where}: {reserved[0]!r} is no parameter; write it beside 'options'")
    return values


def _as_lists(value: Json) -> Json:
    if isinstance(value, dict):
        return {key: _as_lists(inner) for key, inner in value.items()}
    return [_as_lists(inner) for inner in value] if isinstance(value, list | tuple) else value
