"""The part of a report that shows a study's trials beside a published table which was imported into its folder."""

from __future__ import annotations

import shutil
from pathlib import Path

import pandas as pd

from bench.errors import BenchError
from bench.helpers.atomic import replacing
from bench.report import Section, Table
from bench.reproduce.protocol import protocol_of, samples
from bench.reproduce.table import PaperTable, read
from bench.reproduce.verdict import (
    DIFFERS,
    HEADS,
    NOTE,
    OPEN,
    REPRODUCED,
    Judgement,
    frame,
    judge,
    sentence,
    shown,
    unjudged,
)
from bench.results.results import StoredResults
from bench.topics import Findings

FILES = ("published.csv", "published.toml")
"""What the imported table is called in a study's folder."""

TONES = {REPRODUCED: "good", DIFFERS: "bad", OPEN: "warn"}


def attach(source: Path, folder: Path) -> PaperTable:
    """Copy a published table into a study's folder, in place of an earlier one, and return it.

    Raises:
        BenchError: where the table cannot be read, or the folder has no trials to show beside it.
    """
    table = read(source)
    if not (folder / "study.toml").is_file():
        raise BenchError(
            f"{source} has means and no trials, so it is shown beside trials: give the folder of a run as --output, "
            f"or run its protocol with 'bench reproduce {source}'"
        )
    for name in FILES:
        (folder / name).unlink(missing_ok=True)
    with replacing(folder / f"published{source.suffix}") as temporary:
        shutil.copyfile(source, temporary)
    return table


def sections(findings: Findings) -> list[Section]:
    """Return a section for each folder into which a published table was imported."""
    results = findings.results
    tables = [folder / name for folder in results.paths for name in FILES if (folder / name).is_file()]
    made = []
    for number, path in enumerate(tables, start=1):
        table = read(path)
        source = str(table.settings.get("source", "a published table"))
        name = "published" if len(tables) == 1 else f"published-{number}"
        made.append(section(results, table, f"Beside {source}", name))
    return made


def section(results: StoredResults, table: PaperTable, title: str, name: str) -> Section:
    """Return the section on a table: the verdict, why cells are not judged, and a row a cell."""
    made = protocol_of(table, beside=results)
    judgements = judge(table, samples(table, made, results), made.reasons)
    text = [f"{line[0].upper()}{line[1:]}." for line in (sentence(judgements), *unjudged(judgements))]
    return Section(title, tuple(text), beside(judgements, name))


def beside(judgements: list[Judgement], name: str) -> tuple[Table, ...]:
    """Return the table of judged cells, none without any."""
    rows = pd.DataFrame(shown(judgements), columns=list(HEADS)).set_index("cell")
    if rows.empty:
        return ()
    tones = pd.DataFrame({"verdict": rows["verdict"].map(TONES)}, index=rows.index)
    return (
        Table(
            name, "Printed means (and SDs) beside ours.", rows, tones=tones, note=f"{NOTE}.",
            data=frame(judgements),
        ),
    )  # fmt: skip
