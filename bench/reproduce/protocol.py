"""Make the study that repeats the protocol of a published table, and take its samples from the results."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from bench.contract.typing import Floats
from bench.helpers.errors import BenchError
from bench.helpers.parsing import JsonObject
from bench.helpers.text import slug
from bench.plugins import loading
from bench.reproduce.names import load_problem, optimizer_of, problem_of
from bench.reproduce.table import PaperCell, PaperTable
from bench.results.results import StoredResults
from bench.study import Study


@dataclass
class Protocol:
    """The study that repeats a table.

    Attributes:
        study: problems, optimizers, budget and trials; None where no cell can be run.
        cells: the labels of problem and optimizer in the study, by cell of the table.
        reasons: why the other cells are not run, in a sentence, by cell.
    """

    study: Study | None = None
    cells: dict[PaperCell, tuple[str, str]] = field(default_factory=dict)
    reasons: dict[PaperCell, str] = field(default_factory=dict)


def protocol_of(
    table: PaperTable, trials: int | None = None, seed: int = 0, *, beside: StoredResults | None = None
) -> Protocol:
    """Return the protocol of a table: as many runs and evaluations as it prints, or ``trials`` runs.

    Args:
        table: what is printed.
        trials: of each cell; by default as many as it prints.
        seed: of the study.
        beside: results that are there already: a printed name is the label of one of their optimizers, or means one.

    Raises:
        BenchError: where the values that all cells share cannot be a study's.
    """
    made = Protocol()
    budgets: dict[int, tuple[int, PaperCell]] = {}
    problems: dict[str, int] = {}
    optimizers: dict[str, JsonObject] = {}
    runs = 0
    for cell in table.cells:
        try:
            optimizer = optimizers.get(cell.optimizer) or _optimizer(table, cell.optimizer, beside)
            label = problem_of(table, cell)
            dimension = problems.get(label) or load_problem(table, cell).dimension
            evaluations = cell.evaluations(dimension)
            if evaluations is None or cell.runs is None:
                raise BenchError(f"the {'budget' if evaluations is None else 'number of runs'} is not printed")
            spent, first = budgets.setdefault(dimension, (evaluations, cell))
            if spent != evaluations:
                raise BenchError(
                    f"its budget is another one than that of line {first.line} in this dimension: such cells belong "
                    "into a table of their own"
                )
        except BenchError as error:
            made.reasons[cell] = str(error)
            continue
        optimizers[cell.optimizer] = optimizer
        problems[label] = dimension
        made.cells[cell] = label, optimizer["label"]
        runs = max(runs, cell.runs)
    if made.cells:
        made.study = Study.from_dict(
            {
                "name": slug(table.name) or "table",
                "title": f"The protocol of {table.name}",
                "seed": seed,
                "trials": trials or runs,
                "budget": {str(dimension): spent for dimension, (spent, _) in budgets.items()},
                "problems": [{"name": name, **table.settings.get("problem", {})} for name in problems],
                "optimizers": list({each["label"]: each for each in optimizers.values()}.values()),
                **({"constraints": table.settings["constraints"]} if "constraints" in table.settings else {}),
            },
            table.name,
        )
    return made


def _optimizer(table: PaperTable, printed: str, beside: StoredResults | None) -> JsonObject:
    """Return a study's table of an optimizer; raises BenchError for one that is not installed or not in results."""
    if beside is not None:
        known = {entry.name: entry.label for entry in beside.study.optimizers}
        known |= {label: label for label in known.values()}
        label = known.get(printed) or known.get(optimizer_of(table, printed)["name"])
        if label is None:
            raise BenchError(f"no optimizer of the results is {printed!r}")
        return {"name": printed, "label": label}
    chosen = optimizer_of(table, printed)
    options = {key: value for key, value in chosen.items() if key not in ("name", "label")}
    loading.load_optimizer(chosen["name"], **options)
    return chosen


def samples(table: PaperTable, made: Protocol, results: StoredResults) -> dict[PaperCell, Floats]:
    """Return the final values of our trials by cell, on the scale of the table; reasons are added for cells without.

    Errors are values less the optimum, and those below the table's ``zero`` are 0, as the rules of CEC have them.
    """
    frame = results.frame
    zero = float(table.settings.get("zero", 0.0))
    found: dict[PaperCell, Floats] = {}
    names = {entry.name: entry.label for entry in results.study.problems}
    for cell, (problem, optimizer) in made.cells.items():
        label = names.get(problem, problem)
        rows = frame[(frame["problem"] == label) & (frame["optimizer"] == optimizer)]
        failed = int((rows["status"] != "ok").sum())
        values = rows["fun"].to_numpy(dtype=np.float64)
        evaluations = cell.evaluations(results.dimension(label)) if len(rows) else None
        optimum = results.facts(label).optimum if table.errors or zero else None
        if len(rows) < 2:
            made.reasons[cell] = "there are fewer than two trials of it"
        elif failed or not np.isfinite(values).all():
            made.reasons[cell] = f"{failed or 'some'} of its {len(rows)} trials failed"
        elif evaluations != results.study.budget.evaluations(results.dimension(label)):
            made.reasons[cell] = "the results have another budget"
        elif table.errors and optimum is None:
            made.reasons[cell] = "the optimum of the problem is not known, and the table prints errors"
        else:
            errors = values - (optimum or 0.0)
            if zero and optimum is not None:
                errors[errors < zero] = 0.0
            found[cell] = errors if table.errors else errors + (optimum or 0.0)
    return found
