"""A study: its optimizers, problems, number of trials and budget; read from TOML."""

from __future__ import annotations

import dataclasses
import json
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tomli_w

from bench.contract.numbers import LARGEST_SEED, MOST_TRIALS, require_whole
from bench.contract.optimizer import Optimizer
from bench.contract.problem import Problem
from bench.contract.seeds import trial_seed
from bench.helpers.errors import BenchError, nearest
from bench.helpers.parsing import JsonObject, parse_toml, read_text
from bench.helpers.text import html_table, listed, short_hash
from bench.plugins import loading, registry
from bench.study import entries
from bench.study.budget import Budget
from bench.study.cell import Cell, Labels, record
from bench.study.entries import Entry
from bench.study.initial import with_initial
from bench.study.rules import KEYS as RULES
from bench.study.rules import Rules, read_rules
from bench.study.targets import Targets
from bench.study.values import Checked, Value
from bench.trial.scoring import scored
from bench.trial.trial import Trial

LONGEST_NAME, LONGEST_TITLE = 100, 1000
UNKNOWN_BUDGET = "an unknown budget"
"""Characters of the name and of the title of a study."""

TRIALS = 30
"""The usual number of trials of an optimizer on a problem."""


@dataclass(frozen=True)
class Study:
    """A comparison of optimizers on problems.

    Attributes:
        name: a short name, which also names the default output folder.
        problems: the problems, with distinct labels.
        optimizers: the optimizers, with distinct labels.
        trials: the number of runs of each optimizer on each problem.
        budget: evaluations a run may spend: a number, a multiple of the dimension such as ``"1e4 * d"``, or a table by
            dimension such as ``{"10": 200_000}``.
        seed: the seed that all trials' seeds derive from.
        title: one line on what is compared.
        rules: how the points of a trial are evaluated, and what ends it before its budget.
        targets: what a report counts as reached (:meth:`bench.study.targets.Targets.read`); None: the usual ones of the
            problems. They decide no trial's result.
        subject: the label of the optimizer that the study is about: reports test it against each rival, and no other
            pair. It decides no trial's result; "" where there is none.
    """

    name: str
    problems: tuple[Entry, ...]
    optimizers: tuple[Entry, ...]
    trials: Checked[int] = Checked(lambda value, what: require_whole(what, value, 1, MOST_TRIALS), TRIALS)
    budget: Checked[Budget] = Checked(Budget.read, Budget.read(10_000))
    seed: Checked[int] = Checked(lambda value, what: require_whole(what, value, 0, LARGEST_SEED), 0)
    title: str = ""
    rules: Checked[Rules] = Checked(read_rules, Rules())
    targets: Checked[Targets | None] = Checked(Targets.read)
    subject: str = ""

    def __post_init__(self) -> None:
        """Check the name and the title; raises BenchError, as each field does for a value that it cannot hold.

        Whether the values fit each other is checked where a study is read, changed or run (:meth:`require_sound`): a
        part of a study may be less.
        """
        if not isinstance(self.name, str) or not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}", self.name):
            raise BenchError(
                f"the name {self.name!r} must be up to 100 letters, digits, '.', '_' or '-', as it names a folder"
            )
        if not isinstance(self.title, str) or not self.title.isprintable():
            raise BenchError("the title holds a control character or a line break, or is no text")
        if len(self.title) > LONGEST_TITLE:
            raise BenchError(f"the title has {len(self.title):,} characters, more than {LONGEST_TITLE:,}")

    @classmethod
    def load(cls, source: str | os.PathLike[str] | Mapping[str, object]) -> Study:
        """Return the study of an installed name (``"thesis"``), of a TOML file's path, or of such a file's content.

        Raises:
            BenchError: for an unknown name, an unreadable or malformed file, or contents that are not a valid study.
        """
        if isinstance(source, Mapping):
            return cls.from_dict(dict(source))
        text, where = _read(source)
        try:
            data = parse_toml(text)
        except ValueError as error:
            raise BenchError(f"study {where} is not valid TOML: {error}") from error
        return cls.from_dict(data, where)

    @classmethod
    def from_dict(cls, data: Mapping[str, object], where: str = "given") -> Study:
        """Return the study that a parsed TOML document describes; raises BenchError naming the first invalid entry."""
        known = {item.name for item in dataclasses.fields(cls)} - {"rules"} | RULES
        for key in data:
            if key not in known:
                raise BenchError(f"study {where}: unknown key {key!r}{nearest(key, known)}")
        for key in ("name", "title", "subject"):
            if not isinstance(data.get(key, ""), str):
                raise BenchError(f"study {where}: {key!r} must be a text, not {data[key]!r}")
        if not data.get("name"):
            raise BenchError(f'study {where} has no name; add a line such as name = "my-study"')
        lists = {key: entries.read_entries(data.get(key), key, where) for key in ("problems", "optimizers")}
        content: JsonObject = {key: value for key, value in data.items() if key not in RULES} | lists
        try:
            study = cls(**content, rules=Rules(**{key: data[key] for key in RULES & data.keys()}))
        except BenchError as error:
            raise BenchError(f"study {where}: {error}") from error
        study.require_sound(where)
        return study

    def override(self, **changes: object) -> Study:
        """Return a copy with the given fields replaced; None leaves a field as it is."""
        chosen: dict[str, Any] = {key: value for key, value in changes.items() if value is not None}
        return dataclasses.replace(self, **chosen)

    @property
    def budget_words(self) -> str:
        """The budget of a trial in words, such as ``"10,000 d evaluations"``; imported results may not say it."""
        known = self.budget != Budget.read(1) or len(self.imported) < len(self.optimizers)
        return self.budget.words if known else UNKNOWN_BUDGET

    def beside(self, optimizers: Iterable[str] = (), problems: Iterable[str] = ()) -> Study:
        """Return a copy with more optimizers and problems, by name or pattern; raises BenchError for a label twice."""
        both: dict[str, Any] = {}
        for key, names in (("optimizers", optimizers), ("problems", problems)):
            added = entries.read_entries([{"name": name} for name in names], key, repr(self.name)) if names else ()
            both[key] = (*getattr(self, key), *added)
        study = dataclasses.replace(self, **both)
        study.require_sound()
        return study

    def require_sound(self, where: str = "") -> None:
        """Raise BenchError where entries or values do not fit each other, as in a file that is refused.

        ``where`` is the study in sentences, by default its name.
        """
        where = where or repr(self.name)
        for key in ("problems", "optimizers"):
            if not getattr(self, key):
                raise BenchError(f"study {where} needs at least one of the {key}")
            entries.check_labels(getattr(self, key), key, where)
        if self.subject:
            self._named("optimizer", self.optimizers, self.subject)

    def problem(self, label: str) -> Problem:
        """Load the problem of that label, scored under the study's handling of its constraints where it has any."""
        entry = self._named("problem", self.problems, label)
        options = deepcopy(entry.options)
        known = options.pop("initial", [])
        loaded = with_initial(loading.load_problem(entry.name, **options), known)
        return scored(loaded, self.rules.constraints, self.rules.on_error)

    def files(self, label: str) -> tuple[str, ...]:
        """Return the files that the problem or the optimizer of that label names as read by it."""
        return next((entry.files for entry in (*self.problems, *self.optimizers) if entry.label == label), ())

    def optimizer(self, label: str) -> Optimizer:
        """Load the optimizer of that label."""
        entry = self._named("optimizer", self.optimizers, label)
        return loading.load_optimizer(entry.name, **deepcopy(entry.options))  # a plug-in may change a list

    def packages(self) -> dict[str, list[str]]:
        """Return the labels of the optimizers by the file, family or package that each comes from.

        Nothing is loaded. Those whose results were imported come from none.
        """
        labels: dict[str, list[str]] = {}
        for entry in self.optimizers:
            if not loading.is_imported(entry.name):
                labels.setdefault(loading.package(entry.name), []).append(entry.label)
        return labels

    @property
    def imported(self) -> list[str]:
        """The labels of the optimizers whose results were imported, and which cannot be run here."""
        return [entry.label for entry in self.optimizers if loading.is_imported(entry.name)]

    def _named(self, kind: str, entries: Iterable[Entry], label: str) -> Entry:
        by_label = {entry.label: entry for entry in entries}
        if label not in by_label:
            raise BenchError(f"study {self.name!r} has no {kind} {label!r}{nearest(label, by_label)}")
        return by_label[label]

    def dimensions(self, load: Callable[[str], Problem] | None = None) -> dict[str, int]:
        """Load every problem, by ``load`` with its label; return their dimensions by label.

        Raises:
            BenchError: for the first name, option, recording or budget that cannot work, and for targets that no
                problem has.
        """
        problems = {entry.label: (load or self.problem)(entry.label) for entry in self.problems}
        if self.targets is not None:
            self.targets.require_metric(any(problem.expected for problem in problems.values()))
        for problem in problems.values():
            self.rules.goal(problem)
        dimensions = {label: problem.dimension for label, problem in problems.items()}
        self._least(dimensions)
        return dimensions

    def check_optimizers(self, labels: Iterable[str], dimensions: Mapping[str, int]) -> None:
        """Load these optimizers, and check the budget against the largest generation; raises likewise.

        ``dimensions`` are those of the problems, by label.
        """
        least = self._least(dimensions)
        for label in labels:
            self.optimizer(label).check_budget(least, label)

    def _least(self, dimensions: Mapping[str, int]) -> int:
        """Return the smallest budget of any problem; raises BenchError where a dimension has none."""
        return min(self.budget.evaluations(dimension) for dimension in {*dimensions.values()})

    def cells(self, dimensions: Mapping[str, int]) -> dict[Labels, Cell]:
        """Return the cells of the study by the labels of problem and optimizer, in their order.

        ``dimensions`` are those of the problems, by label, as far as they are known.
        """
        handling = {"constraints": self.rules.constraints, "on_error": self.rules.on_error} | self.rules.deciding
        problems = {entry.label: record(**_about(entry), **handling) for entry in self.problems}
        optimizers = {entry.label: record(**_about(entry)) for entry in self.optimizers}
        evaluations = {
            label: self.budget.evaluations(dimensions[label]) if label in dimensions else 0 for label in problems
        }
        return {
            (problem, optimizer): Cell(problems[problem], optimizers[optimizer], evaluations[problem], self.seed)
            for problem in problems
            for optimizer in optimizers
        }

    def plan(self, seeds: Mapping[Labels, Labels] | None = None) -> Iterator[Trial]:
        """Yield every trial of the study in randomised complete blocks: one trial of each cell, in random order.

        A machine that is busy for a while then slows all algorithms alike. The order is that of the seeds, which are
        hashes, so that it is random and stays the same when trials are added.

        Args:
            seeds: the labels from which the seeds of a cell are made, where they are others than it is shown with.
        """
        cells = [(problem.label, optimizer.label) for problem in self.problems for optimizer in self.optimizers]
        labels = {cell: (seeds or {}).get(cell, cell) for cell in cells}
        for number in range(self.trials):
            block = [Trial(*cell, number, trial_seed(self.seed, *labels[cell], number)) for cell in cells]
            yield from sorted(block, key=lambda trial: trial.seed)

    def to_toml(self) -> str:
        """Return the study as a TOML document that loads back as an equal study."""
        table = {key: getattr(self, key) for key in ("name", "title", "seed", "trials", "budget")}
        table["subject"] = self.subject or None
        table |= self.rules.unusual | {"targets": self.targets}
        for key in ("problems", "optimizers"):
            table[key] = [entry.as_dict() for entry in getattr(self, key)]
        plain = {key: value.plain if isinstance(value, Value) else value for key, value in table.items()}
        return tomli_w.dumps({key: value for key, value in plain.items() if value is not None})

    def _repr_html_(self) -> str:
        """Return the study as a table, for a notebook."""
        rows = [
            *([("title", self.title)] if self.title else []),
            (f"problems ({len(self.problems):,})", listed([entry.label for entry in self.problems], 10)),
            (f"optimizers ({len(self.optimizers):,})", listed([entry.label for entry in self.optimizers], 10)),
            ("trials of each on each", f"{self.trials:,}"),
            ("budget of a trial", self.budget_words),
            ("seed", self.seed),
        ]
        return html_table(f"Study {self.name}", rows)

    def identity(self) -> str:
        """Return a hash of all settings that decide a trial's result, so without the number of trials and the title.

        Targets and subject decide none; of the rules, those are a part of it that decide and are not the default ones.
        """
        content = dataclasses.asdict(self) | {"trials": None, "title": None, "budget": self.budget.plain}
        left_out = {"rules", "targets", "subject"}
        content = {key: value for key, value in content.items() if key not in left_out} | self.rules.deciding
        for entry in (*content["problems"], *content["optimizers"]):
            del entry["files"]  # whose content decides, and not their names
        return short_hash(json.dumps(content, sort_keys=True, default=str))


def _about(entry: Entry) -> JsonObject:
    return {"label": entry.label, "name": entry.name, "options": entry.options}


def _read(source: str | os.PathLike[str]) -> tuple[str, str]:
    """Return the text of a study and its name in messages."""
    installed = registry.entries("studies")
    if str(source) in installed:
        text: str = registry.load("studies", str(source)).read_text(encoding="utf-8")
        return text, repr(str(source))
    path = Path(source)
    if path.suffix != ".toml" and not os.path.exists(path):  # noqa: PTH110 - unlike Path.exists, it never raises
        raise BenchError(
            f"unknown study {str(source)!r}{nearest(str(source), installed)}, or give the path of a TOML file"
        )
    try:
        return read_text(path), str(path)
    except (OSError, ValueError) as error:
        raise BenchError(f"the study file {path} cannot be read: {getattr(error, 'strerror', error)}") from error
