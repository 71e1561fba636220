"""Fig. 7.5 and the thesis's other criterion of cost: the time of a trial, and the memory of a search."""

from __future__ import annotations

from dataclasses import replace
from importlib.resources import files

import pandas as pd

from bench import Study
from bench.analysis import timing
from bench.report import Section, Table, listing, seconds, timing_figure

TITLE = "Execution time (thesis Fig. 7.5) and memory"
HARNESS = "random-search"  # its search needs nothing of its own


def sections(frame: pd.DataFrame, study: Study) -> list[Section]:
    """Return the section on time and memory, none without a finished trial whose time is known."""
    table = timing(frame)
    finished = table[table["trials"] > 0].dropna(subset=["wall_mean"])
    if finished.empty:
        return []
    finished = finished.sort_values("wall_mean", kind="stable").set_index("optimizer")
    mean = finished["wall_mean"]
    times = listing([f"{seconds(value)} with {label}" for label, value in mean.items()])
    text = (
        f"One trial takes {times} on average. The thesis shows its times as bars without numbers, so none can be "
        "compared. The section on time has the medians and the quartiles."
    )
    shown = pd.DataFrame(
        {
            "trials": finished["trials"],
            "mean time in s": mean,
            "times the fastest": mean / mean.iloc[0],
            "in the objective %": 100 * finished["objective_mean"] / mean,
        }
    )
    caption = "Mean wall time of one trial, and the percentage of it spent in the objective."
    decimals = {"times the fastest": 1, "in the objective %": 1}
    bars = replace(
        timing_figure(table),
        name="execution-time",
        caption="Mean wall time of one trial of each optimizer over all datasets, as in thesis Fig. 7.5.",
    )
    memory = memory_of(study)
    words, items = ((_memory_text(memory),), (_memory_table(memory),)) if len(memory) else ((), ())
    return [Section(TITLE, (text, *words), (bars, Table("mean-times", caption, shown, decimals=decimals), *items))]


def measured() -> pd.DataFrame:
    """Return what ``python performance/memory.py`` measured: a row an optimizer and number of agents.

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
    return (
        "The thesis counts reduced memory usage among the advantages of the swarms. Trials do not record their memory. "
        f"Measured apart, on dataset 12 by performance/memory.py, a search needs at its peak {between} above "
        f"the process that runs it, up to {harness:,.0f} kB of which are the harness’s. The process itself, with the "
        f"libraries that the optimizer needs, takes {size} MB."
    )


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
