"""bench export: write results in the formats of other tools."""

from __future__ import annotations

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
    from pandas import DataFrame, concat

    from bench.execution.journal import journals

    tables = []
    for head, records in journals(folder):
        table = DataFrame({key: [head[key]] * len(records) for key in ("problem", "optimizer", "trial", "seed")})
        table["evaluation"] = [each["n"] + 1 for each in records]
        for place, name in enumerate(head["variables"]):
            table[f"x_{name}"] = [each["x"][place] for each in records]
        table["f"] = [each["f"] for each in records]
        for place in range(max((len(each["g"]) for each in records), default=0)):
            table[f"g{place + 1}"] = [each["g"][place] for each in records]
        table["seconds"] = [each["s"] for each in records]
        table["error"] = [each.get("error", "") for each in records]
        tables.append(table)
    if not tables:
        raise BenchError(f"{folder} has no journal: no trial had evaluations of 0.1 s or more, nor 'journal = true'")
    output.mkdir(parents=True, exist_ok=True)
    concat(tables).to_csv(output / "evaluations.csv", index=False)
    print_line(f"export: {output / 'evaluations.csv'}")
