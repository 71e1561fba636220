"""bench export: write results in the formats of other tools."""

from __future__ import annotations

from operator import itemgetter
from pathlib import Path
from typing import Annotated

import typer

from bench.cli.console import StudyFolder
from bench.formats import EXPORTABLE, described
from bench.helpers.console import print_line
from bench.helpers.errors import BenchError


def command(
    folder: StudyFolder,
    kind: Annotated[str | None, typer.Option("--format", help=f"{described(EXPORTABLE)}.")] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder to write; default: FOLDER/export/FORMAT.")
    ] = None,
    evaluations: Annotated[
        bool,
        typer.Option("--evaluations", help="Write evaluations.csv: each one that is noted in the journals of trials."),
    ] = False,
) -> None:
    """Write a study's results for other tools: for cocopp or IOHanalyzer, or as plain tables.

    With --evaluations, the evaluations that were noted of trials whose evaluations are slow, as a table.
    """
    if evaluations:
        _write_evaluations(folder, output or folder / "export")
    if kind is None:
        if not evaluations:
            raise BenchError("give a --format, or --evaluations")
        return
    from bench.cli.answer import read, warn_if_old
    from bench.formats.exporting import export
    from bench.results.results import StoredResults

    warn_if_old(folder, read(folder))
    output, results = output or folder / "export" / kind, StoredResults(folder)
    for note in export(results, kind, output):
        print_line(f"note: {note}", "yellow")
    print_line(f"export: {output}")


def _write_evaluations(folder: Path, output: Path) -> None:
    """Write the evaluations in the journals of a folder as a CSV file."""
    from pandas import DataFrame

    from bench.execution.journal import journals

    rows = [
        {name: head[name] for name in ("problem", "optimizer", "trial", "seed")}
        | {"evaluation": each["n"] + 1}
        | {f"x_{name}": value for name, value in zip(head["variables"], each["x"], strict=True)}
        | {"f": each["f"], "seconds": each["s"], "error": each.get("error", "")}
        | {f"g{number}": value for number, value in enumerate(each.get("g", []), start=1)}
        for head, records in journals(folder)
        for each in sorted(records, key=itemgetter("n"))
    ]
    if not rows:
        raise BenchError(f"{folder} has no journal: no trial had evaluations of 0.1 s or more, nor 'journal = true'")
    output.mkdir(parents=True, exist_ok=True)
    DataFrame(rows).to_csv(output / "evaluations.csv", index=False)
    print_line(f"export: {output / 'evaluations.csv'}")
