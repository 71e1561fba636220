"""The pages of a board: the first one with a table for each setting, and one for each study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from bench.board.archive import LONGEST, Archive
from bench.board.ranks import RULE, SettingRanks, standings
from bench.helpers.text import count, joined, listed, option, printable
from bench.report import Section, Table, write_page
from bench.scoring.constraints import DEFAULT

SHORT = 12  # digits shown of a hash


def write_index(
    path: Path, archives: Sequence[Archive], standings: Sequence[SettingRanks], addresses: Mapping[str, str]
) -> None:
    """Write the first page: a table for each setting, and below them the rule and the archives."""
    rows = [
        {"archive": archive.name, "study": archive.study.title or archive.study.name, "trials": f"{archive.trials:,}"}
        | archive.provenance
        for archive in archives
    ]
    caption = f"{count(len(archives), 'archive')}, each unpacked and compared with its checksums and digests."
    table = _table("archives", caption, pd.DataFrame(rows), archives, addresses)
    settings = [_setting(standing, archives, addresses) for standing in standings]
    lead = (
        f"{count(len(archives), 'archive')}; a section for each of {count(len(standings), 'setting')}, and below them "
        "the rule and the archives."
    )
    write_page(path, "A board of packed studies", lead, [*settings, Section("The rule", (RULE,), (table,))])


def write_study(path: Path, archive: Archive) -> None:
    """Write the page of a study: where its trials come from, and its ranks among its own optimizers."""
    study = archive.study
    facts = {"board": "index.html", "archive": archive.name, "study": f"{study.name}, identity {study.identity()}"}
    facts |= {"trials": f"{archive.trials:,}"} | archive.provenance
    links = pd.DataFrame({"value": ["../index.html", *[""] * (len(facts) - 1)]}, index=pd.Index(facts))
    unknown = listed([entry.label for entry in study.problems if entry.label not in archive.dimensions])
    warnings = (f"No table has {unknown}: no trial ended there, so the dimension is unknown.",) if unknown else ()
    sections = [Section("Provenance", items=(_pairs("Where the trials come from.", facts, links),), warnings=warnings)]
    sections += [_setting(standing, [archive], {}) for standing in standings([archive])]
    if archive.again:
        outcomes = {again.trial: again.sentence for again in archive.again}
        sections.append(Section("Trials made again", items=(_pairs("What became of each.", outcomes),)))
    for number, record in enumerate(archive.records, start=1):
        pairs = {key: printable(option(record[key]), 2_000) for key in sorted(record) if key not in ("data", "code")}
        sections.append(
            Section(f"Environment {number}", items=(_pairs(f"Environment {number}, as the run noted it.", pairs),))
        )
    sections.append(Section("The study as it was frozen", code=study.to_toml()))
    lead = (
        f"{count(len(study.optimizers), 'optimizer')} on {count(len(study.problems), 'problem')}, {study.budget_words} "
        "a trial. The ranks on this page are those among the optimizers of this study alone, by the rule of the board."
    )
    write_page(path, study.title or study.name, lead, sections)


def _pairs(caption: str, facts: Mapping[str, str], links: pd.DataFrame | None = None) -> Table:
    index = pd.Index([printable(key, LONGEST) for key in facts], name="what")
    frame = pd.DataFrame({"value": [*facts.values()]}, index=index)
    return Table(caption, caption, frame, links=links, most_rows=len(frame))


def _setting(standing: SettingRanks, archives: Sequence[Archive], addresses: Mapping[str, str]) -> Section:
    setting, rows = standing.setting, standing.rows
    ranked = int(rows["place"].notna().sum())
    notes = [*standing.notes]
    if setting.constraints != DEFAULT:
        notes.append(f"Constraints are handled by {setting.constraints}.")
    if setting.looks:
        notes.append(f"Looks at {joined([*map(str, setting.looks)])} trials stopped cells that were decided.")
    if setting.alone:
        notes.append("These trials were imported and nobody set their budget, so they are ranked among themselves.")
    if ranked < len(rows):
        notes.append("An optimizer without a trial on some problem has no rank.")
    if ranked == 1:
        notes.append("One optimizer alone: nothing is compared here.")
    caption = f"{count(ranked, 'optimizer')} ranked on {listed(setting.labels)}."
    return Section(setting.title, tuple(notes), (_table(setting.title, caption, rows, archives, addresses),))


def _table(
    name: str, caption: str, rows: pd.DataFrame, archives: Sequence[Archive], addresses: Mapping[str, str]
) -> Table:
    """Return a table whose archives link to the ``addresses`` of their pages, with those that differ in red."""
    differ = {archive.name for archive in archives if any(again.different for again in archive.again)}
    shown = rows if any(archive.again for archive in archives) else rows.drop(columns="made again")
    return Table(
        name,
        caption,
        shown.assign(**{"SHA-256": rows["SHA-256"].str[:SHORT]}),
        decimals={"mean rank": 2, "chance to end lower": 3},
        links=pd.DataFrame({"archive": rows["archive"].map(lambda name: addresses.get(name, ""))}),
        lost=pd.DataFrame({"made again": rows["archive"].isin(differ)}),
        most_rows=len(rows),
    )
