"""The page: one HTML file that fetches nothing."""

from __future__ import annotations

import base64
import hashlib
import re
from dataclasses import dataclass, replace
from functools import cached_property
from importlib import resources
from itertools import groupby
from xml.etree import ElementTree

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from bench.report.parts import Figure, Section, Table, TableCell

MOST_ROWS = 400  # of a table; a reader of more wants the file
PRINTED_ROWS = 40  # of the table behind a figure; a longer one stays off paper
LONG_TEXT = 30  # characters, beyond which a cell may break its lines
ZOOM = 1.45  # from a figure's 8 points to the size of the page's text

SVG = "{http://www.w3.org/2000/svg}"
HREF = "{http://www.w3.org/1999/xlink}href"
COORDINATES = {"d", "points", "x", "y", "x1", "x2", "y1", "y2", "cx", "cy", "width", "height"}
TEXTS = {"text", "tspan"}


@dataclass(frozen=True)
class Item:
    """A table, or a figure with its SVG, and the files it was written to."""

    anchor: str
    files: list[str]
    table: Table | None = None
    figure: Figure | None = None
    svg: Markup | None = None

    @cached_property
    def grid(self) -> Grid:
        """The cells of the table, or of the data behind the figure; fails for a frame that no page can show."""
        part = self.figure.table if self.figure is not None else self.table
        if part is None:
            raise TypeError("an item is a table or a figure")
        return grid(part)


@dataclass(frozen=True)
class View:
    """A section ready to be shown; ``files`` are downloads to be listed, (path, what it is)."""

    anchor: str
    section: Section
    items: list[Item]
    views: list[View]
    files: list[tuple[str, str]]


@dataclass(frozen=True)
class Grid:
    """A table's cells as the page shows them.

    Attributes:
        header: the columns' titles.
        classes: how its columns are set: ``t2`` a second column of short texts, ``w3`` a third of long ones; others
            hold numbers. A class of the table spares one for each cell.
        ems: about how wide it is, in units of its font's size; on paper the font is as small as this asks for.
        rows: the first rows' cells.
        total: how many rows the table has.
    """

    header: list[str]
    classes: str
    ems: int
    rows: list[list[TableCell]]
    total: int


def render(title: str, lead: str, views: list[View]) -> str:
    """Return the page as HTML; all text is escaped by the template."""
    environment = Environment(
        loader=PackageLoader("bench.report", ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["by_folder"] = by_folder
    style, script = _asset("page.css"), _asset("page.js")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return environment.get_template("page.html.j2").render(
        title=title, lead=lead, views=views, style=style, script=script, script_hash=digest,
        widest=_widest(views), printed_rows=PRINTED_ROWS,
    )  # fmt: skip


def grid(table: Table) -> Grid:
    """Return what the page shows of a table: all of it, or its first rows where it is long."""
    shown = table
    if len(table.frame) > MOST_ROWS:
        frames = {name: getattr(table, name) for name in ("frame", "bold", "italic", "marks", "lost")}
        shown = replace(table, **{name: frame.head(MOST_ROWS) for name, frame in frames.items() if frame is not None})
    header, rows = shown.header, shown.rows
    lengths = [max((len(row[i].text + row[i].mark) for row in rows), default=0) for i in range(len(header))]
    words = [max(map(len, title.split()), default=0) for title, _ in header]
    ems = sum(1 + 0.6 * max(min(length, LONG_TEXT), word) for length, word in zip(lengths, words, strict=True))
    kinds = [
        f"{'w' if length > LONG_TEXT else 't'}{place}"
        for place, ((_, numeric), length) in enumerate(zip(header, lengths, strict=True), 1)
        if not numeric
    ]
    return Grid([title for title, _ in header], " ".join(kinds), round(ems), rows, len(table.frame))


def by_folder(files: list[tuple[str, str]]) -> dict[str, list[tuple[str, list[str]]]]:
    """Return downloads by their first folder, as what it is and the paths of neighbours that differ in kind alone.

    Files outside any folder come under "report".
    """
    folders: dict[str, list[tuple[str, list[str]]]] = {}
    for (stem, what), group in groupby(files, lambda file: (file[0].rpartition(".")[0], file[1])):
        folder = stem.partition("/")[0] if "/" in stem else "report"
        folders.setdefault(folder, []).append((what, [path for path, _ in group]))
    return folders


def inline(svg: str, name: str, caption: str) -> Markup:
    """Return a matplotlib figure's SVG for the page: light, its ids made its own by ``name``, ``caption`` as label.

    Left out is what does not show: metadata, ids nothing refers to, bare groups, a style repeated by a whole group,
    decimals beyond 0.01 points. Matplotlib's style sheet, which would reach the whole page, is in the page's own.
    """
    root = ElementTree.fromstring(svg)
    width = float(root.attrib["viewBox"].split()[2])
    referred = re.findall(r'(?:="|url\()#([^")]+)', svg)
    present = {element.get("id") for element in root.iter()}
    ids = {  # a dot is in no anchor of the page
        old: f"{name}.{number}" for number, old in enumerate(dict.fromkeys(referred)) if old in present
    }
    for element in root.iter():
        element.tag = element.tag.removeprefix(SVG)
        element.attrib = {
            key.replace(HREF, "href"): _attribute(element.tag, key, value, ids)
            for key, value in element.attrib.items()
            if key != "id" or value in ids
        }
        if element.tag not in TEXTS:
            element.text = (element.text or "").strip()
    root[:] = _slim(root)
    root.attrib = {
        "viewBox": root.attrib["viewBox"],
        "style": f"--width:{width * ZOOM * 96 / 72:.0f}px",
        "role": "img",
        "aria-label": caption,
    }
    return Markup(ElementTree.tostring(root, encoding="unicode").replace(" />", "/>"))


def _attribute(tag: str, key: str, value: str, ids: dict[str, str]) -> str:
    """Return an attribute's value with its ids renamed and no more characters than it needs."""
    if key == "id":
        return ids[value]
    if key in COORDINATES and tag not in TEXTS:  # browsers set letters on whole pixels, where the least shift shows
        short = re.sub(
            r"-?\d*\.?\d+(?:e-?\d+)?", lambda number: f"{float(number[0]):.2f}".rstrip("0").rstrip("."), value
        )
        return re.sub(r"\s*([A-Za-z])\s*", r"\1", " ".join(short.split())) if key == "d" else short
    if key == "style":
        value = re.sub(r"([:;]) +", r"\1", value)
    return re.sub(r"(^|url\()#([^)]+)", lambda found: f"{found[1]}#{ids.get(found[2], found[2])}", value)


def _slim(parent: ElementTree.Element) -> list[ElementTree.Element]:
    """Return an element's children, a group's common style hoisted to it and groups that say nothing taken away."""
    kept: list[ElementTree.Element] = []
    for child in parent:
        child.tail = child.tail if parent.tag in TEXTS else None
        child[:] = _slim(child)
        if child.tag == "g":
            _hoist(child)
        if child.tag == "g" and not child.attrib:
            kept += child
        elif child.tag not in {"metadata", "style"} and (child.tag != "defs" or len(child)):
            kept.append(child)
    return kept


def _hoist(group: ElementTree.Element) -> None:
    """Move the style that all shapes of a group share to the group, where they inherit every property of it."""
    shapes = [child for child in group if child.tag != "defs"]
    styles = {shape.get("style", "") for shape in shapes}
    if len(shapes) > 1 and len(styles) == 1 and "style" not in group.attrib:
        style = styles.pop()
        if style and all(each.lstrip().startswith(("fill", "stroke")) for each in style.split(";")):
            group.set("style", style)
            for shape in shapes:
                del shape.attrib["style"]


def _widest(views: list[View]) -> int:
    """Return the number of columns of the page's widest table."""
    items = [item for view in views for each in (view, *view.views) for item in each.items]
    return max((len(item.grid.header) for item in items), default=0)


def _asset(name: str) -> Markup:
    """Return one of the page's own files; it is trusted text."""
    return Markup(resources.files("bench.report").joinpath(name).read_text(encoding="utf-8"))
