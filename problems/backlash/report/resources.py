"""The thesis's other criterion of cost: the memory of a search. The harness's section on time has its Fig. 7.5."""

from __future__ import annotations

from importlib.resources import files

import pandas as pd

from bench import Study
from bench.report import Section, Table
from problems.backlash.report.accuracy import SAY

TITLE = "Memory of a search"
HARNESS = "random-search"  # its search needs nothing of its own


def sections(study: Study) -> list[Section]:
    """Return the section on memory, none where that of the study's optimizers was not measured."""
    memory = memory_of(study)
    return [Section(TITLE, (_memory_text(memory),), (_memory_table(memory),))] if len(memory) else []


def measured() -> pd.DataFrame:
    """Return the measurements of ``python performance/memory.py``: a row an optimizer and number of agents.

    Columns: optimizer (plug-in name), agents, process_mb (the process before the search), resident_kb and traced_kb
    (the peak of the search above it, as the system and as Python see it); on an AMD EPYC, Linux, Python 3.11.
    """
    with files("problems.backlash.report").joinpath("memory.csv").open(encoding="utf-8") as file:
        return pd.read_csv(file)


def memory_of(study: Study) -> pd.DataFrame:
    """Return the rows of :func:`measured` on the study's own optimizers and agents, by label."""
    searches = measured().query("optimizer != @HARNESS")
    asked = [(entry.name, entry.options.get("agents"), entry.label) for entry in study.optimizers]
    chosen = pd.DataFrame(asked, columns=["optimizer", "agents", "label"])
    chosen = chosen[pd.to_numeric(chosen["agents"], errors="coerce").notna()].astype({"agents": int})
    rows = chosen.merge(searches, on=["optimizer", "agents"]).drop(columns="optimizer")
    return rows.set_index("label").rename_axis("optimizer")


def _memory_text(memory: pd.DataFrame) -> str:
    resident = memory["resident_kb"].sort_values(kind="stable")
    harness = measured().query("optimizer == @HARNESS")["resident_kb"].max()
    between = f"{resident.iloc[0]:,.0f} kB"
    if len(resident) > 1:
        between += f" with {resident.index[0]} and {resident.iloc[-1]:,.0f} kB with {resident.index[-1]}"
    process = memory["process_mb"]
    size = f"{process.min():.0f}" + (f" to {process.max():.0f}" if process.max() > process.min() else "")
    return SAY("memory", between, harness, size)


def _memory_table(memory: pd.DataFrame) -> Table:
    titles = {
        "agents": "agents",
        "process_mb": "process before, MB",
        "resident_kb": "resident, kB",
        "traced_kb": "arrays and objects, kB",
    }
    return Table(
        "memory",
        "Peak memory of one search above that of its process: resident, and the arrays and objects of Python.",
        memory.rename(columns=titles).astype(int),
        note="Not of this run: medians of some searches of 60,000 evaluations on dataset 12, each in a process of its "
        "own on an AMD EPYC under Linux (python performance/memory.py).",
    )
