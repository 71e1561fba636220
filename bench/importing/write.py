"""Write imported runs as a study's folder, whole or not at all."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from bench.errors import BenchError
from bench.helpers.atomic import replacing
from bench.importing import naming
from bench.importing.runs import Run
from bench.plugins.loading import IMPORTED
from bench.storage.folder import Folder
from bench.storage.rows import packed
from bench.study import Entry, Study
from bench.study.budget import Budget


def study_of(name: str, runs: Iterable[Run]) -> Study:
    """Return the study that numbered runs make up.

    Its budget is the largest number of evaluations of any run, by dimension where all dimensions are known: other tools
    have no budget that every run may spend.
    """
    problems: dict[str, int | None] = {}
    optimizers: dict[str, None] = {}
    spent: dict[int | None, int] = {}
    trials = 0
    for run in runs:
        problems[run.problem] = run.dimension
        optimizers[run.optimizer] = None
        spent[run.dimension] = max(run.nfev, spent.get(run.dimension, 1))
        trials = max(trials, (run.number or 0) + 1)
    budget: Budget = max(spent.values())
    if len(spent) > 1 and None not in spent:
        budget = {str(dimension): most for dimension, most in sorted(spent.items(), key=lambda item: item[0] or 0)}
    clean = re.sub(r"[^A-Za-z0-9._-]+", "-", re.sub(r"\.(tgz|tar(\.\w+)?|zip|csv)$", "", name)).strip("._-")[:100]
    return Study(
        clean or "imported",
        tuple(Entry(label if naming.is_offered(label) else f"{IMPORTED}:{label}", label) for label in problems),
        tuple(Entry(f"{IMPORTED}:{label}", label) for label in optimizers),
        trials=trials,
        budget=budget,
        title=f"Imported from {name}" if name.isprintable() else "Imported results",
    )


def numbered(runs: Iterable[Run]) -> list[Run]:
    """Return the runs with the numbers of their trials: those given, or their order within their cell.

    Raises:
        BenchError: for a number that is given twice.
    """
    results: list[Run] = []
    counts: Counter[tuple[str, str]] = Counter()
    seen: set[tuple[str, str, int]] = set()
    for run in runs:
        number = counts[run.problem, run.optimizer] if run.number is None else run.number
        counts[run.problem, run.optimizer] += 1
        if (key := (run.problem, run.optimizer, number)) in seen:
            raise BenchError(f"trial {number} of {run.optimizer} on {run.problem} occurs twice")
        seen.add(key)
        results.append(replace(run, number=number))
    return results


def write(folder: Path, study: Study, runs: Iterable[Run], record: dict[str, Any]) -> None:
    """Write a study's folder in which every row refers to the one environment, ``record``.

    Raises:
        BenchError: where the folder holds anything, or cannot be written.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise BenchError(f"{folder} is there already and not empty; give another -o")
    with replacing(folder) as temporary:
        temporary.mkdir(parents=True)
        target = Folder(temporary)
        target.claim(study)
        with target.store.writer() as writer:
            number = writer.environment(record)
            with writer.transaction():
                for run in runs:
                    writer.put(_row(run) | {"environment": number})
        target.write_environments()
        if folder.is_dir():
            folder.rmdir()  # it is empty


def _row(run: Run) -> dict[str, Any]:
    """Return a run as a row of the store, with NULL for unknown values."""
    row: dict[str, Any] = {"status": "ok", "fun": run.fun, "nfev": run.nfev, "x": {}, "metrics": {}} | dict(run.columns)
    trace = {"trace": run.trace} if row["status"] == "ok" else {}
    return packed(row | trace) | {"problem": run.problem, "optimizer": run.optimizer, "trial": run.number}
