"""Choose and shorten what the interactive part shows: the curves of runs, their records, and data that they fitted.

Every value is kept as its distance from the reference of its problem: the known optimum, or the lowest value found
where that is unknown or beaten. A problem's budgets are shares of its own, the same for all problems.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench import analysis
from bench.analysis.anytime import quartiles
from bench.analysis.cells import NEAR, ReferenceValue, reference_values, scores
from bench.analysis.cells import variables as variables_of
from bench.columns import FEATURES, RESERVED
from bench.objective import Trace
from bench.plots import style
from bench.report.interactive import Interactive, interactive
from bench.report.interactive.coding import coded, packed, short, signal
from bench.study import Entry
from bench.study.targets import KINDS, Targets
from bench.topics.explore.command import optimizer_words, problem_words
from bench.topics.findings import Findings
from bench.typing import Floats

MOST_RUNS = 12_000
"""Runs with their record and curve; of a larger study, the first of each cell, and the quartiles of every cell."""
MOST_CELLS = 30_000
"""Cells of the largest study that has an interactive part."""
MOST_POINTS, FEWEST_POINTS = 60, 8
"""Budgets at which curves are kept."""
MOST_LEVELS = 480_000
"""Numbers of all curves together, which decides between these two."""
MOST_COORDINATES = 40_000
"""Coordinates of best points, all together; beyond, points are left out."""
MOST_SAMPLES = 3000
"""Samples of a signal; the first of a longer one."""
MOST_SIGNALS = 40
"""Problems whose data are shown; the first of more."""

DASHES: dict[Any, list[int]] = {
    "-": [],
    "--": [6, 3],
    "-.": [6, 3, 2, 3],
    ":": [2, 3],
    (0, (5, 1)): [9, 2],
}
SHAPES = {
    "o": "circle",
    "s": "square",
    "^": "triangle-up",
    "D": "diamond",
    "v": "triangle-down",
    "P": "cross",
    "X": "M-1,-1L1,1M1,-1L-1,1",
}
"""The line styles and markers of :mod:`bench.plots.style` in Vega's terms."""


def look_further(findings: Findings) -> Interactive:
    """Return the interactive part of a report, or a sentence on why it has none."""
    if findings.trials.frame.empty:
        return Interactive(hint="Without a trial there is nothing to look into.")
    data = explore(findings)
    if data is None:
        return Interactive(hint=f"A study of more than {MOST_CELLS:,} cells has no interactive part.")
    return interactive(data)


def explore(findings: Findings) -> dict[str, Any] | None:
    """Return the data of the interactive part, as JSON can hold them; None for a study too large for it.

    Keys: ``name``; ``optimizers``; ``problems``; ``grid``, the evaluations of the largest budget at which curves are
    kept (another budget's are in proportion, at least 1); ``targets``, their title and whether they are the report's;
    ``cells``, of which each has its ``problem`` and ``optimizer`` by place; ``texts``, to which records refer by place;
    ``complete``, whether all runs are there; ``notes``, sentences on what was left out.
    """
    cells = len(findings.trials.problems) * len(findings.trials.optimizers)
    return None if cells > MOST_CELLS else _Explored(findings).data()


@dataclass(frozen=True)
class _Explored:
    findings: Findings

    def data(self) -> dict[str, Any]:
        findings = self.findings
        cells = [self.cell(*key, rows) for key, rows in self.rows.items()]
        problems = [self.problem(label) for label in findings.trials.problems]
        return {
            "name": findings.study.name,
            "optimizers": self.optimizers(),
            "problems": problems,
            "grid": self.grid.tolist(),
            "targets": {"title": self.chosen.unit, "rising": self.chosen.rising},
            "cells": cells,
            "texts": list(self.texts),
            "complete": self.complete,
            "notes": self.notes(problems),
        }

    # what is kept

    @cached_property
    def rows(self) -> dict[tuple[str, str], list[int]]:
        """The numbers of the frame's rows of each cell that has any, in the study's order."""
        cells = self.findings.trials.whole.groupby(["problem", "optimizer"], observed=True)
        rows_of = cast("Mapping[tuple[str, str], NDArray[np.int64]]", cells.indices)
        return {cell: rows.tolist() for cell, rows in rows_of.items()}

    @cached_property
    def columns(self) -> dict[str, list[Any]]:
        """The frame's columns as lists, which are read faster than the frame."""
        frame = self.findings.trials.whole
        names = ["trial", "seed", "status", "fun", "nfev", "wall_s", "objective_s", "stop", "error"]
        points = [f"x_{name}" for variables in self.variables.values() for name in variables] if self.points_too else []
        return {name: frame[name].tolist() for name in dict.fromkeys([*names, *points, *self.metrics])}

    @cached_property
    def complete(self) -> bool:
        return len(self.findings.trials.whole) <= MOST_RUNS

    @cached_property
    def kept(self) -> int:
        """The runs of each cell that are kept where not all are."""
        return MOST_RUNS // len(self.rows)

    @cached_property
    def grid(self) -> NDArray[np.int64]:
        curves = len(self.findings.trials.whole) if self.complete else (self.kept + 3) * len(self.rows)
        points = min(max(MOST_LEVELS // max(curves, 1), FEWEST_POINTS), MOST_POINTS)
        return analysis.evaluation_grid(max(self.budgets.values()), points)

    @cached_property
    def budgets(self) -> dict[str, int]:
        """The most evaluations that a trial on each problem was allowed."""
        allowed = cast("Mapping[str | tuple[str, str], int]", self.findings.trials.allowed)
        most: dict[str, int] = {}
        for key, budget in allowed.items():
            label = key[0] if isinstance(key, tuple) else key
            most[label] = max(most.get(label, 1), budget)
        return most

    @cached_property
    def references(self) -> dict[str, ReferenceValue]:
        whole = self.findings.trials.whole
        lowest = scores(whole).groupby(whole["problem"].astype(object)).min()
        finite = {str(label): float(best) for label, best in lowest.items() if np.isfinite(best)}
        return reference_values(finite, self.findings.trials.optima)

    @cached_property
    def points_too(self) -> bool:
        """Whether the runs' best points are kept."""
        runs = sum(
            len(self.shown(rows)) * self.findings.trials.dimensions.get(key[0], 0) for key, rows in self.rows.items()
        )
        return runs <= MOST_COORDINATES

    def shown(self, rows: list[int]) -> list[int]:
        return rows if self.complete else rows[: self.kept]

    @cached_property
    def texts(self) -> dict[str, int]:
        """Reasons to stop and errors, numbered as they come up."""
        return {}

    def text(self, text: Any) -> int:
        return self.texts.setdefault("" if pd.isna(text) else str(text), len(self.texts))

    # optimizers and problems

    def optimizers(self) -> list[dict[str, Any]]:
        entries = {entry.label: entry for entry in self.findings.study.optimizers}
        pens = style.pens(self.findings.trials.optimizers, self.findings.display.coloured, grey=False)
        return [
            {
                "label": label,
                "color": pens[label].color,
                "dash": DASHES[pens[label].line],
                "shape": SHAPES[pens[label].marker],
                "options": _options(entries[label]),
                "command": optimizer_words(entries[label]),
            }
            for label in self.findings.trials.optimizers
        ]

    def problem(self, label: str) -> dict[str, Any]:
        findings = self.findings
        entries = {entry.label: entry for entry in findings.results.study.problems}
        members = findings.trials.pooled.members[label]
        reference = self.references.get(label)
        dimension = findings.trials.dimensions.get(label)
        features = {name: value for name, value in findings.trials.known[label].features.items() if name != "instance"}
        return {
            "label": label,
            "features": features | ({"dimension": dimension} if dimension else {}),
            "budget": self.budgets[label],
            "reference": None if reference is None else short(reference.value, 10),
            "known": reference is not None and reference.known,
            "precision": label in findings.trials.precisions,
            "targets": self.targets.get(label, []),
            "members": [] if members == [label] else members,
            "options": _options(entries[members[0]]),
            "commands": packed([problem_words(entries[member], findings.results.study) for member in members]),
            "variables": self.variables[label] if self.points_too else [],
            "metrics": self.metrics,
            "data": self.signals.get(label),
        }

    @cached_property
    def chosen(self) -> Targets:
        """The report's targets, or relative ones where those are no values of the objective."""
        own = self.findings.anytime.target_set
        return KINDS["relative"] if own.by_metric else own

    @cached_property
    def targets(self) -> dict[str, list[list[float | int | None]]]:
        """Each target of each problem, from the easiest: its level, and its distance from the reference."""
        findings = self.findings
        if self.chosen == findings.anytime.target_set:
            table = findings.anytime.targets
        else:
            table = analysis.target_table(
                self.chosen, findings.trials.whole, findings.trials.traces, findings.trials.optima
            )
        table, by_problem = self.chosen.in_unit(table), dict[str, list[list[float | int | None]]]()
        for label, level, target in zip(table["problem"], table["tau"], table["target"], strict=True):
            if label in self.references:
                by_problem.setdefault(str(label), []).append(
                    [short(level, 4), short(max(target - self.references[str(label)].value, 0.0), 5)]
                )
        return by_problem

    @cached_property
    def variables(self) -> dict[str, list[str]]:
        by_problem = self.findings.trials.whole.groupby("problem", observed=True)
        return {str(label): [name[2:] for name in variables_of(trials)] for label, trials in by_problem}

    @cached_property
    def metrics(self) -> list[str]:
        """The domain metrics, columns of numbers."""
        frame = self.findings.trials.whole
        usual = (*RESERVED, *(column.name for column in FEATURES))
        names = [name for name in map(str, frame) if name not in usual and not name.startswith("x_")]
        return [name for name in names if pd.api.types.is_numeric_dtype(frame[name])]

    @cached_property
    def signals(self) -> dict[str, dict[str, Any]]:
        """The data of the problems to which points are fitted, of the first such problems; a failing one has none."""
        by_problem: dict[str, dict[str, Any]] = {}
        for label in self.findings.trials.problems if self.points_too else ():
            if len(by_problem) < MOST_SIGNALS and self.findings.trials.pooled.members[label] == [label]:
                data = self._signal(label)
                by_problem |= {label: data} if data else {}
        return by_problem

    def _signal(self, label: str) -> dict[str, Any] | None:
        if self.findings.trials.known[label].reason:
            return None
        try:
            data = self.findings.results.problem(label).unscored.fitted_data()
            if data is None or not len(data.t):
                return None
            t = np.asarray(data.t, dtype=np.float64)
            uniform = len(t) > 1 and np.allclose(np.diff(t), t[1] - t[0], rtol=1e-6, atol=0)
            return {
                "t": [short(t[0], 10), short((t[-1] - t[0]) / (len(t) - 1), 10)]
                if uniform
                else {"values": [short(time, 8) for time in t[:MOST_SAMPLES]]},
                "values": signal(data.values[:MOST_SAMPLES]),
                "samples": len(t),
                "model": str(data.model),
                "t_title": str(data.t_title),
                "title": str(data.title),
            }
        except Exception:  # a plug-in may raise anything, and its runs are shown without it
            return None

    # cells

    def cell(self, problem: str, optimizer: str, rows: list[int]) -> dict[str, Any]:
        shown, columns = self.shown(rows), self.columns
        distances = self.distances(problem, optimizer, rows)
        cell: dict[str, Any] = {
            "problem": self.places[0][problem],
            "optimizer": self.places[1][optimizer],
            "trials": len(rows),
            "failed": sum(columns["status"][row] != "ok" for row in rows),
        }
        if not self.complete:
            cell["quartiles"] = coded(quartiles(distances)[[1, 0, 2]])
        if not shown:
            return cell
        kept = {name: [values[row] for row in shown] for name, values in columns.items()}
        ok = [status == "ok" for status in kept["status"]]
        cell |= {
            "seed": ["" if pd.isna(seed) else str(seed) for seed in kept["seed"]],
            "fun": [short(value) if fine else None for value, fine in zip(kept["fun"], ok, strict=True)],
            "nfev": packed([short(number) for number in kept["nfev"]]),
            "wall_s": packed([short(seconds, 3) for seconds in kept["wall_s"]]),
            "objective_s": packed([short(seconds, 3) for seconds in kept["objective_s"]]),
            "stop": packed([self.text(reason) for reason in kept["stop"]]),
            "curve": coded(distances[: len(shown)]),
        }
        if self.complete:
            cell["place"] = [self.finals[row] for row in shown]
        numbers = [trial % self.stride for trial in kept["trial"]]
        if numbers != list(range(len(shown))):
            cell["number"] = numbers
        if len(members := self.findings.trials.pooled.members[problem]) > 1:
            cell["member"] = [min(trial // self.stride, len(members) - 1) for trial in kept["trial"]]
        if not all(ok):
            reasons = zip(kept["status"], kept["error"], ok, strict=True)
            cell["error"] = [None if fine else self.text(f"{what}: {_first_line(why)}") for what, why, fine in reasons]
        if self.points_too:
            cell["x"] = _joined([kept[f"x_{name}"] for name in self.variables[problem]])
        if self.metrics:
            cell["metrics"] = _joined([kept[name] for name in self.metrics])
        return cell

    @cached_property
    def finals(self) -> list[int]:
        """The place of each row's final value among those of its problem, near-ties as ties, failed trials last.

        What is not compared has the place of its own final value.
        """
        whole, compared = self.findings.trials.whole, self.findings.trials.frame
        return final_places(whole.assign(fun=compared["fun"].reindex(whole.index).fillna(whole["fun"])))

    @cached_property
    def stride(self) -> int:
        """By which the trials' numbers of one instance differ from those of the next; see ``pool_instances``."""
        trials = self.findings.results.frame["trial"]
        return int(trials.max()) + 1 if len(trials) else 1

    @cached_property
    def places(self) -> tuple[dict[str, int], dict[str, int]]:
        problems, optimizers = self.findings.trials.problems, self.findings.trials.optimizers
        return {label: i for i, label in enumerate(problems)}, {label: i for i, label in enumerate(optimizers)}

    def distances(self, problem: str, optimizer: str, rows: list[int]) -> Floats:
        """Return the distance of each trial of a cell from the reference at each budget, +inf for a failed trial.

        A trial without a trace has its best value from its last evaluation on.
        """
        budget, columns, traces = self.budgets[problem], self.columns, self.findings.trials.traces
        spent = np.maximum(np.floor(self.grid * (budget / self.grid[-1]) + 0.5), 1).astype(np.int64)
        values = np.full((len(rows), len(spent)), np.inf)
        for curve, row in zip(values, rows, strict=True):
            fun = columns["fun"][row]
            if columns["status"][row] == "ok" and np.isfinite(fun):
                trace = traces.get((problem, optimizer, columns["trial"][row]))
                last = Trace(np.array([min(columns["nfev"][row], budget)]), np.array([fun]))
                curve[:] = (trace or last).at(spent)
        if problem not in self.references:
            return values
        reference = self.references[problem].value
        above: Floats = values - reference
        above[above <= NEAR * abs(reference)] = 0.0
        return above

    # what was left out

    def notes(self, problems: Sequence[dict[str, Any]]) -> list[str]:
        """Return sentences on what was left out, and on what is not as in the rest of the report."""
        runs, notes = len(self.findings.trials.whole), []
        if not self.complete:
            single = f"the first {self.kept} runs of each cell" if self.kept else "no single runs"
            notes.append(
                f"The study has {runs:,} runs, more than the {MOST_RUNS:,} that fit into a page: it holds the "
                f"quartiles of every cell, from all runs, and {single}. Ranks are then those of medians, and the "
                "shares of targets reached those of median runs."
            )
        if not self.points_too:
            notes.append("The runs’ best points are left out, as the page would grow; tables/trials.csv has them.")
        if any(problem["targets"] for problem in problems) and self.chosen != self.findings.anytime.target_set:
            notes.append("Targets are relative here: those of the report are no values of the objective.")
        if len(self.signals) == MOST_SIGNALS < len(problems):
            notes.append(f"The data of the first {MOST_SIGNALS} problems are here.")
        cut = [label for label, data in self.signals.items() if data["samples"] > MOST_SAMPLES]
        if cut:
            notes.append(f"Of longer signals, the first {MOST_SAMPLES:,} samples are here.")
        return notes


def final_places(frame: pd.DataFrame) -> list[int]:
    """Return the place of each trial's score among those of its problem; equal scores, also nearly, share a place."""
    final = scores(frame, merge=True)
    return list(final.groupby(frame["problem"].astype(object)).rank("dense").astype(int))


def _joined(columns: Sequence[Sequence[Any]]) -> list[str]:
    """Return the numbers of each row of these columns as a text, missing ones as empty ones."""
    rows = zip(*columns, strict=True)
    return [",".join("" if pd.isna(number) else f"{float(number):.7g}" for number in row) for row in rows]


def _options(entry: Entry) -> str:
    return ", ".join(f"{name} = {value}" for name, value in entry.options.items())


def _first_line(error: Any) -> str:
    return "" if pd.isna(error) else str(error).split("\n", 1)[0][:300]
