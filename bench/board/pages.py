"""The pages of a board: what stands on them, and their HTML, which loads nothing and escapes all text."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from bench.board.archive import LONGEST, Archive
from bench.board.ranks import RULE, Row, Standing, standings
from bench.helpers.text import count, joined, listed, option, printable
from bench.report.interactive.part import digest
from bench.scoring.constraints import DEFAULT

WIDE = 30  # characters from which a cell may break into lines
SHORT = 12  # digits shown of a hash
MOST = 1_000  # rows of a table; board.csv has all

HEADS = ("place", "mean rank", "chance to end lower", "optimizer", "archive", "trials", "seed", "versions", "date")


@dataclass(frozen=True)
class Cell:
    """A cell of a table: its text, the page that it links to, whether it is a number, and whether it is bad news."""

    text: str
    link: str = ""
    number: bool = False
    lost: bool = False

    @property
    def long(self) -> bool:
        """Whether the text may break into lines."""
        return len(self.text) > WIDE


@dataclass(frozen=True)
class Part:
    """A part of a page: paragraphs, a text to copy, a table, and notes below it."""

    title: str
    text: tuple[str, ...] = ()
    code: str = ""
    heads: tuple[str, ...] = ()
    rows: tuple[tuple[Cell, ...], ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def ems(self) -> int:
        """About how wide the table is, in units of its font size."""
        columns = zip(self.heads, *([cell.text for cell in row] for row in self.rows), strict=True)
        return round(sum(1 + 0.6 * max(min(len(each), WIDE) for each in column) for column in columns))


@dataclass(frozen=True)
class Page:
    """A page; ``back`` is the address of the board on the page of a study."""

    title: str
    lead: tuple[str, ...]
    parts: tuple[Part, ...]
    back: str = ""


def render(page: Page) -> str:
    """Return the page as HTML."""
    environment = Environment(
        loader=PackageLoader("bench.board", ""), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip
    style, script = (
        Markup(resources.files("bench.report").joinpath(name).read_text(encoding="utf-8"))
        for name in ("page.css", "page.js")
    )
    template = environment.get_template("board.html.j2")
    return template.render(page=page, style=style, script=script, script_hash=digest(script))


def index(archives: Sequence[Archive], found: Sequence[Standing], addresses: Mapping[str, str]) -> Page:
    """Return the first page: the rule, a table for each setting, and the archives."""
    checked = any(each.again for each in archives)
    heads = ("archive", "study", "SHA-256", "trials", "seed", "versions", "date", *(["made again"] * checked))
    rows = tuple(
        (
            Cell(each.name, addresses[each.name]), Cell(each.study.title or each.study.name),
            Cell(each.sha256[:SHORT]), Cell(f"{each.trials:,}", number=True),
            Cell(each.seed, number=True), Cell(each.versions), Cell(each.date),
            *([_verified(each)] * checked),
        )
        for each in archives
    )  # fmt: skip
    lead = f"{count(len(archives), 'archive')}, each unpacked and compared with its checksums and digests."
    tables = [_table(each, addresses, checked) for each in found]
    parts = (Part("How the ranks are made", (RULE,)), *tables, Part("Archives", heads=heads, rows=rows))
    return Page("A board of packed studies", (lead,), parts)


def study(archive: Archive) -> Page:
    """Return the page of a study: its ranks among its own optimizers, and where its trials come from."""
    own, checked = archive.study, bool(archive.again)
    facts = {
        "archive": archive.name,
        "SHA-256 of the archive": archive.sha256,
        "study": f"{own.name}, identity {own.identity()}",
        "seed": archive.seed,
        "trials": f"{archive.trials:,}",
        "versions": archive.versions,
        "date": archive.date,
        "made again": archive.verified or "no trial",
    }
    parts = [Part("Provenance", heads=("what", "value"), rows=_pairs(facts))]
    parts += [_table(each, {}, checked) for each in standings([archive])]
    if unknown := [each.label for each in own.problems if each.label not in archive.dimensions]:
        parts.append(Part("Left out", (f"The dimension of {listed(unknown)} is unknown, as no trial ended there.",)))
    if archive.again:
        parts.append(Part("Trials made again", heads=("trial", "outcome"), rows=_pairs(
            {each.trial: each.sentence for each in archive.again}
        )))  # fmt: skip
    for number, record in enumerate(archive.records, start=1):
        said = {key: printable(option(record[key]), 2_000) for key in sorted(record) if key not in ("data", "code")}
        parts.append(Part(f"Environment {number}", heads=("key", "value"), rows=_pairs(said)))
    parts.append(Part("The study as it was frozen", code=own.to_toml()))
    lead = (
        f"{count(len(own.optimizers), 'optimizer')} on {count(len(own.problems), 'problem')}, {own.budget_words} a "
        "trial. The ranks on this page are those among the optimizers of this study alone, by the rule of the board."
    )
    return Page(own.title or own.name, (lead,), tuple(parts), "../index.html")


def _pairs(facts: Mapping[str, str]) -> tuple[tuple[Cell, ...], ...]:
    return tuple((Cell(printable(key, LONGEST)), Cell(value)) for key, value in facts.items())


def _table(found: Standing, addresses: Mapping[str, str], checked: bool) -> Part:
    """Return the table of a setting; the archives link to the ``addresses`` of their pages."""
    setting, ranked = found.setting, sum(bool(row.place) for row in found.rows)
    text = f"{count(ranked, 'optimizer')} ranked on {listed(setting.labels)}."
    notes = [*found.notes]
    if setting.constraints != DEFAULT:
        notes.append(f"Constraints are handled by {setting.constraints}.")
    if setting.looks:
        notes.append(f"Looks at {joined([*map(str, setting.looks)])} trials stopped cells that were decided.")
    if setting.alone:
        notes.append("These trials were imported and nobody set their budget, so they are ranked among themselves.")
    if ranked < len(found.rows):
        notes.append("An optimizer without a trial on some problem has no rank.")
    if ranked == 1:
        notes.append("One optimizer alone: nothing is compared here.")
    if len(found.rows) > MOST:
        notes.append(f"The first {MOST:,} of {len(found.rows):,} rows are shown; board.csv has all.")
    rows = tuple(_cells(row, addresses, checked) for row in found.rows[:MOST])
    heads = (*HEADS, *(["made again"] * checked), "SHA-256")
    return Part(setting.title, (text,), heads=heads, rows=rows, notes=tuple(notes))


def _cells(row: Row, addresses: Mapping[str, str], checked: bool) -> tuple[Cell, ...]:
    archive, (least, most) = row.archive, row.trials
    return (
        Cell(str(row.place or "–"), number=True),
        Cell(_digits(row.mean_rank, 2), number=True),
        Cell(_digits(row.chance, 3), number=True),
        Cell(row.optimizer.label),
        Cell(archive.name, addresses.get(archive.name, "")),
        Cell(f"{least}" if least == most else f"{least} to {most}", number=True),
        Cell(archive.seed, number=True),
        Cell(archive.versions),
        Cell(archive.date),
        *([_verified(archive)] * checked),
        Cell(archive.sha256[:SHORT]),
    )


def _verified(archive: Archive) -> Cell:
    return Cell(archive.verified, lost=any(each.different for each in archive.again))


def _digits(value: float, decimals: int) -> str:
    return "–" if math.isnan(value) else f"{value:.{decimals}f}"


def table(found: Sequence[Standing]) -> list[dict[str, object]]:
    """Return all rows of all tables with every digit, for the CSV file."""
    return [
        {
            "table": number, "suite": each.setting.suite, "dimension": each.setting.dimension,
            "budget": each.setting.budget, "problems": len(each.setting.problems),
            "constraints": each.setting.constraints, "looks": " ".join(map(str, each.setting.looks)),
            "place": row.place or "", "mean_rank": row.mean_rank, "chance": row.chance,
            "optimizer": row.optimizer.label, "archive": row.archive.name, "trials_least": row.trials[0],
            "trials_most": row.trials[1], "seed": row.archive.seed, "versions": row.archive.versions,
            "date": row.archive.date, "made_again": row.archive.verified, "sha256": row.archive.sha256,
        }
        for number, each in enumerate(found, start=1)
        for row in each.rows
    ]  # fmt: skip
