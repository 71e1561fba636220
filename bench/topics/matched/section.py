"""The leader and its rivals under the same conditions, where the optimizers of the study run under several."""

from __future__ import annotations

import pandas as pd

from bench.report.parts import File, Section, Table
from bench.report.prose import speaker
from bench.report.wording import MISSING, count, listing, options
from bench.topics.findings import Findings
from bench.topics.matched.controls import REPORTED, controls
from bench.topics.matched.differing import options_differing
from bench.topics.topic import Topic

TITLE = "Under the same conditions"
SAY = speaker(__package__)


def section(findings: Findings) -> Section | None:
    """Return the table of the leader against its rivals, None where nothing differs or nothing ran under the same."""
    chances = findings.of(controls).chances
    reported = chances.loc[chances["conditions"] == REPORTED, ["first", "second"]]
    if chances[["first", "second"]].drop_duplicates().shape[0] <= len(reported):
        return None
    leader, conditions = str(reported["first"].iloc[0]), list(chances["conditions"].unique())
    counts = [
        f"{int((rows['low'] > 0.5).sum())} of {count(len(rows), 'rival')} {'' if name == REPORTED else 'with '}{name!s}"
        for name, rows in chances.groupby("conditions", sort=False)
    ]
    text = [
        SAY("table", options_differing(findings), leader),
        f"The 95% interval of the probability lies above 0.5 against {'; '.join(counts)}.",
    ]
    if labels := [entry.label for entry in findings.study.controls]:
        text.append(SAY("controls", labels))
    if missing := findings.of(controls).cost:
        text.append(f"The table is not complete: {missing}.")
    return Section(TITLE, tuple(text), (_table(findings, chances, leader, conditions),))


def _table(findings: Findings, chances: pd.DataFrame, leader: str, conditions: list[str]) -> Table:
    cells = [
        f"{chance:.2f}" + ("" if pd.isna(low) else f" [{low:.2f}, {high:.2f}]")
        for chance, low, high in zip(chances["probability"], chances["low"], chances["high"], strict=True)
    ]
    shown = chances.assign(cell=cells).pivot(index="rival", columns="conditions", values="cell")
    shown = shown.reindex(index=chances["rival"].unique(), columns=conditions).fillna(MISSING).rename_axis(columns=None)
    apart = [
        f"{listing(labels)} {'has' if len(labels) == 1 else 'have'} no such option as {options({name: value})}"
        for matched in findings.of(controls).matched
        for name, value in matched.values.items()
        if (labels := [label for label, names in matched.apart.items() if name in names])
    ]
    return Table(
        "same-conditions",
        f"The probability that a run of {leader} beats one of each rival, with its 95% interval.",
        shown,
        note="; ".join(["The mean over problems of A12", *apart]) + ".",
        data=chances,
    )


def tables(findings: Findings) -> list[File]:
    """Return the trials of controls, where any were run."""
    frame = findings.results.controls
    about = "The trials of controls, which no other table, figure or test has but that of the same conditions."
    return [File("tables/controls.csv", about, frame)] if len(frame) else []


TOPIC = Topic(TITLE, section, place=10, files=tables)
