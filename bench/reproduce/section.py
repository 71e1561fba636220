"""The part of a report that shows a study's trials beside a published table in its folder."""

from __future__ import annotations

import shutil
from pathlib import Path

import pandas as pd

from bench.helpers.atomic import replacing
from bench.report import Section, Table
from bench.reproduce.protocol import protocol_of, samples
from bench.reproduce.table import PaperTable, read
from bench.reproduce.verdict import HEADS, NOTE, Judgement, frame, judge, sentences, shown, unjudged
from bench.results.results import StoredResults
from bench.topics import Findings

FILE = "published.csv"
"""What the table is called in a study's folder."""

TITLE = "In your units"


def attach(source: Path, folder: Path) -> None:
    """Copy a published table into a study's folder, in place of an earlier one."""
    with replacing(folder / FILE) as temporary:
        shutil.copyfile(source, temporary)


def section(findings: Findings) -> Section | None:
    """Return the published tables in the folders beside our trials, None without any."""
    results = findings.results
    paths = [folder / FILE for folder in results.paths if (folder / FILE).is_file()]
    text, tables = list[str](), list[Table]()
    for number, path in enumerate(paths, start=1):
        table = read(path)
        judgements = judged(table, results)
        source = str(table.settings.get("source", "a published table"))
        text += [f"Beside {source}: {'. '.join((*sentences(judgements), *unjudged(judgements)))}."]
        tables += beside(judgements, "published" if len(paths) == 1 else f"published-{number}")
    return Section(TITLE, tuple(text), tuple(tables)) if text else None


def judged(table: PaperTable, results: StoredResults) -> list[Judgement]:
    """Return the verdict on each cell of a table, by the trials of some results."""
    made = protocol_of(table, beside=results)
    return judge(table, samples(table, made, results), made.reasons)


def beside(judgements: list[Judgement], name: str) -> tuple[Table, ...]:
    """Return the table of judged cells, none without any."""
    rows = pd.DataFrame(shown(judgements), columns=list(HEADS)).set_index("cell")
    if rows.empty:
        return ()
    caption = "Printed means (and SDs) beside ours."
    return (Table(name, caption, rows, note=f"{NOTE}.", data=frame(judgements)),)
