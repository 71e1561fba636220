"""Render the report as one HTML file that loads nothing else."""

from __future__ import annotations

import re
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from typing import NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from bench.report.documentation import Documentation, guide
from bench.report.library import as_json, digest, library
from bench.report.parts import MOST_ROWS, Figure, Part, Section, Table, TableCell

UPRIGHT, WIDE = 12, 50  # columns of a shaded table, and letters of their titles, above which these stand upright
SIGN = 2  # characters that the sign of sorting takes beside a title
LONG_TEXT = 30  # characters beyond which a cell may break into lines
ZOOM = 1.45  # scales a figure's 8 points to the size of the page's text

PAGE_COLOURS = {"#000000": "currentColor", "#ffffff": "var(--page)", "#dddddd": "var(--grid)"}
"""The colours of a figure's ink, paper and grid, and those of the page, light or dark, that replace them there."""
TAG = re.compile(r"<[^>]+>")
FURTHER_DIGITS = re.compile(r"(\.\d\d)\d+")


@dataclass(frozen=True)
class Item:
    """A table, or a figure with its SVG, and the files that hold it."""

    anchor: str
    files: list[str]
    part: Part
    svg: Markup | None = None

    @cached_property
    def grid(self) -> PageTable:
        """The cells of the table or of the figure's data; raises for a frame that the page cannot show."""
        return grid(self.part.table if isinstance(self.part, Figure) else self.part)


@dataclass(frozen=True)
class View:
    """A section ready to be rendered; ``files`` are those of the report, where it lists them."""

    anchor: str
    section: Section
    items: list[Item]
    views: list[View]
    files: list[FileRow]


class FileRow(NamedTuple):
    """A file of the report in all its formats: the path without its ending, the endings, and what it holds."""

    stem: str
    endings: list[str]
    about: str


@dataclass(frozen=True)
class PageTable:
    """The cells of a table as the page shows them.

    Attributes:
        header: the columns' titles.
        classes: the types of its columns: ``t2`` for short texts in the second column, ``w3`` for long texts in the
            third; other columns hold numbers. One class of the table replaces a class of every cell. ``heat`` is for
            a table with shades, ``blocks`` for one with verdicts, whose rows become blocks on a narrow screen.
        ems: about how wide the table is, in units of its font size; the font shrinks so that it fits.
        rows: the cells of the rows shown.
        total: the number of rows of the table.
    """

    header: list[str]
    classes: str
    ems: int
    rows: list[list[TableCell]]
    total: int


def render(
    title: str,
    lead: str,
    views: list[View],
    *,
    guides: bool = False,
) -> str:
    """Return the page as HTML; the template escapes all text.

    Args:
        title: of the page.
        lead: the line below it.
        views: the sections.
        guides: whether those of :mod:`bench.report.documentation` are beside the page, which then links to them.
    """
    anchors, beside, environment = _anchors(views), Documentation(guides), _environment()
    environment.filters |= {"as_json": as_json, "terms": beside.terms}
    environment.filters["address"] = lambda part: f"#{anchors[part]}" if part in anchors else beside.address(part)
    items = _items(views)
    scripts = [library()] if any(isinstance(item.part, Figure) and item.part.live for item in items) else []
    scripts.append(_asset("page.js"))
    return environment.get_template("page.html.j2").render(
        title=title, lead=lead, views=views, style=_asset("page.css"), scripts=scripts,
        hashes=[digest(script) for script in scripts], widest=max((len(item.grid.header) for item in items), default=0),
    )  # fmt: skip


def render_guide(name: str) -> str:
    """Return a page of :data:`bench.report.documentation.GUIDES` as HTML, in the style of the report."""
    title, body = guide(name)
    return _environment().get_template("guide.html.j2").render(title=title, body=body, style=_asset("page.css"))


def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("bench.report", ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def _anchors(views: list[View]) -> dict[str, str]:
    """Return the ids that a line can link to, by the titles of sections and their parts."""
    shown = [view for outer in views for view in (outer, *outer.views)]
    return {view.section.title: view.anchor for view in shown}


def grid(table: Table) -> PageTable:
    """Return the cells of a table that the page shows: all, or those of the first rows of a long table."""
    shown = table.arranged(lambda frame: frame.head(MOST_ROWS)) if len(table.frame) > MOST_ROWS else table
    header, rows = shown.header, shown.rows
    lengths = [max((len(row[i].text + row[i].mark) for row in rows), default=0) for i in range(len(header))]
    words = [max(map(len, title.split()), default=0) for title, _ in header]
    ems = sum(1 + 0.6 * max(min(length, LONG_TEXT), word + SIGN) for length, word in zip(lengths, words, strict=True))
    shaded, toned = table.typography.shades is not None, table.typography.tones is not None
    kinds = ["heat"] if shaded else ["blocks"] if toned else []
    wide = len(header) > UPRIGHT or sum(len(title) for title, _ in header) > WIDE
    kinds += ["upright"] if shaded and wide else []
    kinds += [
        f"{'w' if length > LONG_TEXT else 't'}{place}"
        for place, ((_, numeric), length) in enumerate(zip(header, lengths, strict=True), 1)
        if not numeric and (place == 1 or not shaded)
    ]
    return PageTable([title for title, _ in header], " ".join(kinds), round(ems), rows, len(table.frame))


def file_rows(files: Mapping[str, str]) -> list[FileRow]:
    """Return a row a file, given the content of each path: files of one name and content are one in several formats."""
    endings: dict[tuple[str, str], list[str]] = {}
    for path, about in sorted(files.items()):
        stem, _, ending = path.rpartition(".")
        endings.setdefault((stem, about), []).append(ending)
    return [FileRow(stem, formats, about) for (stem, about), formats in endings.items()]


def inline(svg: str, name: str, caption: str) -> Markup:
    """Return the SVG of a matplotlib figure for the page, with ids of its own ``name`` and a caption as label.

    Its metadata are left out, its style sheet, which would affect the whole page and is part of the page's own, and
    digits beyond 0.01 points. Black, white and the grey of the grid become the colours of the page, light or dark; the
    files keep theirs.
    """
    own = f"f{zlib.crc32(name.encode()):x}."  # the anchor of an item has no dot
    opening, _, inside = svg[svg.index("<svg") :].partition(">")
    inside = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>", "", inside, flags=re.DOTALL)
    inside = TAG.sub(lambda tag: _of_page(tag[0], own), inside)
    box = re.findall(r'viewBox="([^"]+)"', opening)[0]
    width = float(box.split()[2]) * ZOOM * 96 / 72
    label = escape(caption)
    return Markup(f'<svg viewBox="{box}" style="--width:{width:.0f}px" role="img" aria-label="{label}">{inside}')


def _of_page(tag: str, own: str) -> str:
    """Return a tag of an SVG with ids that begin with ``own``, and colours of the page."""
    tag = FURTHER_DIGITS.sub(r"\1", tag).replace("xlink:href", "href")
    tag = re.sub(r'( id="|"#|url\(#)', rf"\1{own}", tag)
    return re.sub(r"#(000000|ffffff|dddddd)\b", lambda colour: PAGE_COLOURS[colour[0]], tag)


def _items(views: list[View]) -> list[Item]:
    """Return the tables and figures of all views."""
    return [item for outer in views for view in (outer, *outer.views) for item in view.items]


def _asset(name: str) -> Markup:
    """Return one of the page's own files, as trusted text."""
    return Markup(resources.files("bench.report").joinpath(name).read_text(encoding="utf-8"))
