"""The tables of Figs. 8.3 to 8.5: the amplitude found on a robot's joints before and after tampering."""

from __future__ import annotations

import pandas as pd

from bench.report import Section, Table
from bench.topics import StoredResults
from problems.backlash.report.accuracy import SAY, estimates
from problems.backlash.signature import wrist

UNKNOWN = wrist.PrintedRow(float("nan"), float("nan"), float("nan"))
TITLE = "A robot’s wrist before and after tampering (thesis Figs. 8.3 to 8.5)"


def sections(results: StoredResults, frame: pd.DataFrame, truths: pd.DataFrame) -> list[Section]:
    """Return the section on section 8.3, none for a study without the problems ``wrist-…``."""
    names = {entry.label: entry.name for entry in results.study.problems if entry.name.startswith("wrist-")}
    data = estimates(frame, truths, "amplitude_rpm")
    data = data[data["problem"].isin(set(names)) & data["found"].notna()]
    if data.empty:
        return []
    table = beside_printed(data, names)
    return [Section(TITLE, (SAY("chosen"), *sentences(table, data["optimizer"].nunique())), (_table(table),))]


def beside_printed(data: pd.DataFrame, names: dict[str, str]) -> pd.DataFrame:
    """Return a row a problem and optimizer: mean and stdev of |A| beside the printed ones, all in rps.

    Columns: joint, state, half-gap (rad), expected (the simulated peak), mean, stdev, and the three of the thesis,
    ``expected published``, ``mean published`` and ``stdev published``, missing for joint 1.
    """
    rps = data.assign(found=data["found"] / 60, expected=data["expected"] / 60)
    cells = rps.groupby(["problem", "optimizer"], observed=True).agg(
        expected=("expected", "first"), mean=("found", "mean"), stdev=("found", "std")
    )
    keys = [wrist.parts(names[str(problem)]) for problem in cells.index.get_level_values("problem")]
    printed = pd.DataFrame(
        [wrist.PRINTED.get(key, UNKNOWN) for key in keys], cells.index, list(wrist.PrintedRow._fields)
    )
    gaps = [wrist.AXES[number].half_gaps[wrist.STATES.index(state)] for number, state in keys]
    cells[["joint", "state"]], cells["half-gap"] = keys, gaps
    return cells.join(printed.astype(float).add_suffix(" published"))


def sentences(table: pd.DataFrame, optimizers: int) -> list[str]:
    """Return a sentence on each joint and optimizer: the mean before and after tampering."""
    text = []
    for (joint, optimizer), rows in table.groupby(["joint", "optimizer"], observed=True):
        found, printed = (dict(zip(rows["state"], rows[name], strict=True)) for name in ("mean", "mean published"))
        if set(wrist.STATES) <= set(found):
            known = printed if (joint, wrist.STATES[0]) in wrist.PRINTED else None
            text.append(SAY("joint", joint, optimizer if optimizers > 1 else "", found, known))
    return text


def _table(table: pd.DataFrame) -> Table:
    columns = {"δ in 1e-6 rad": 1e6 * table["half-gap"]}
    for name in wrist.PrintedRow._fields:
        columns |= {f"{name} published": table[f"{name} published"], name: table[name]}
    return Table(
        "wrist",
        "Amplitude |A| in rps on the joints of a robot, healthy and tampered (thesis Figs. 8.3b, 8.4b and 8.5b).",
        pd.DataFrame(columns),
        decimals={"δ in 1e-6 rad": 0} | {column: 3 for column in columns if "δ" not in column},
        note="Expected: the largest deviation of the simulated speed without noise; published: as the thesis expected "
        "it, without saying from what. δ is chosen here.",
    )
