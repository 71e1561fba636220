"""Render the report as one HTML file that loads nothing else."""

from __future__ import annotations

import re
import zlib
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from itertools import groupby
from xml.etree import ElementTree

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from bench.helpers.text import slug
from bench.report.interactive.part import Interactive, digest
from bench.report.parts import Figure, Part, Section, Table, TableCell
from bench.report.paths import shortened
from bench.report.wording import clause

UPRIGHT, WIDE = 12, 50  # columns of a shaded table, and letters of their titles, above which these stand upright
SIGN = 2  # characters that the sign of sorting takes beside a title
LONG_TEXT = 30  # characters beyond which a cell may break into lines
ZOOM = 1.45  # scales a figure's 8 points to the size of the page's text

SVG = "{http://www.w3.org/2000/svg}"
HREF = "{http://www.w3.org/1999/xlink}href"
COORDINATES = {"points", "x", "y", "x1", "x2", "y1", "y2", "cx", "cy", "width", "height"}
TEXTS = {"text", "tspan"}
GRID = "#dddddd"
CLIP = "clip-path"
PAGE_COLOURS = {"#000000": "currentColor", "#ffffff": "var(--page)", GRID: "var(--grid)"}
"""The colours of a figure's ink, paper and grid, and those of the page, light or dark, that replace them there."""
UNTURNED = re.compile(r"rotate\(-?0( [-\d. ]+)?\)")


@dataclass(frozen=True)
class Item:
    """A table, or a figure with its SVG, and the files that hold it."""

    anchor: str
    files: list[str]
    part: Part
    svg: Markup | None = None

    @cached_property
    def grid(self) -> Grid:
        """The cells of the table or of the figure's data; raises for a frame that the page cannot show."""
        return grid(self.part.table if isinstance(self.part, Figure) else self.part)


@dataclass(frozen=True)
class View:
    """A section ready to be rendered; ``files`` are the downloads to list, (path, description)."""

    anchor: str
    section: Section
    items: list[Item]
    views: list[View]
    files: list[tuple[str, str]]


@dataclass(frozen=True)
class Grid:
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
    problems: Mapping[str, str] | None = None,
    further: Interactive | None = None,
) -> str:
    """Return the page as HTML, with its interactive part after the first view; the template escapes all text.

    ``problems`` has the anchor of the section on each problem: rows of tables that name a problem link to it.
    """
    environment = Environment(
        loader=PackageLoader("bench.report", ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= {"by_folder": by_folder, "clause": clause}
    style, script = _asset("page.css"), _asset("page.js")
    return environment.get_template("page.html.j2").render(
        title=title, lead=lead, views=views, style=style, script=script, script_hash=digest(script),
        widest=_widest(views), problems=problems or {}, further=further or Interactive(),
        anchors=_anchors(views),
    )  # fmt: skip


def _anchors(views: list[View]) -> dict[str, str]:
    """Return the ids that a line of the first part can link to, by title: those of parts and of its folded cards."""
    folded = [card.title for view in views[:1] for card in view.section.cards if card.folded]
    return {title: f"card.{slug(title)}" for title in folded} | {view.section.title: view.anchor for view in views}


def grid(table: Table) -> Grid:
    """Return the cells of a table that the page shows: all, or those of the first rows of a long table."""
    shown = table.arranged(lambda frame: frame.head(table.most_rows)) if len(table.frame) > table.most_rows else table
    header, rows = shown.header, shown.rows
    lengths = [max((len(row[i].text + row[i].mark) for row in rows), default=0) for i in range(len(header))]
    words = [max(map(len, title.split()), default=0) for title, _ in header]
    ems = sum(1 + 0.6 * max(min(length, LONG_TEXT), word + SIGN) for length, word in zip(lengths, words, strict=True))
    kinds = ["heat"] if table.shades is not None else ["blocks"] if table.tones is not None else []
    wide = len(header) > UPRIGHT or sum(len(title) for title, _ in header) > WIDE
    kinds += ["upright"] if table.shades is not None and wide else []
    kinds += [
        f"{'w' if length > LONG_TEXT else 't'}{place}"
        for place, ((_, numeric), length) in enumerate(zip(header, lengths, strict=True), 1)
        if not numeric and (place == 1 or table.shades is None)
    ]
    return Grid([title for title, _ in header], " ".join(kinds), round(ems), rows, len(table.frame))


def by_folder(files: list[tuple[str, str]]) -> dict[str, list[tuple[str, list[str]]]]:
    """Return downloads by first folder, as descriptions with the paths of one file in all its formats.

    Files outside any folder come under "report".
    """
    folders: dict[str, list[tuple[str, list[str]]]] = {}
    for (stem, about), group in groupby(files, lambda file: (file[0].rpartition(".")[0], file[1])):
        folder = stem.partition("/")[0] if "/" in stem else "report"
        folders.setdefault(folder, []).append((about, [path for path, _ in group]))
    return folders


def inline(svg: str, name: str, caption: str) -> Markup:
    """Return the SVG of a matplotlib figure for the page: compact, with ids of its ``name`` and a caption as label.

    Invisible parts are removed: metadata, ids that nothing refers to, groups without attributes, a style repeated by a
    whole group, by the texts or by the marks of one shape, turns by 0 degrees, decimals beyond 0.01 points. The lines
    of a grid are one path. Matplotlib's style sheet, which would affect the whole page, is part of the page's own.
    Black, white and the grey of the grid become the colours of the page, light or dark; the files keep theirs.
    """
    root = ElementTree.fromstring(svg)
    font = _common_font(root)
    shapes = {f"#{element.get('id')}": _properties(element) for element in root.iter() if element.get("id")}
    width = float(root.attrib["viewBox"].split()[2])
    targets = re.findall(r'(?:="|url\()#([^")]+)', svg)
    present = {element.get("id") for element in root.iter()}
    short = f"f{zlib.crc32(name.encode()):x}"  # an id is written at each use of a shape, often thousands of times
    ids = {  # the anchor of an item has no dot
        old: f"{short}.{number}" for number, old in enumerate(dict.fromkeys(targets)) if old in present
    }
    for element in root.iter():
        element.tag = element.tag.removeprefix(SVG)
        element.attrib = {
            key.replace(HREF, "href"): _attribute(element.tag, key, value, ids)
            for key, value in element.attrib.items()
            if not (
                (key == "id" and value not in ids)
                or (key == "transform" and UNTURNED.fullmatch(value))
                # the properties of a shape precede those of a mark that uses it
                or (key == "style" and _properties(element).keys() <= shapes.get(element.get(HREF, ""), {}).keys())
            )
        }
        if font and _properties(element).get("font-family") == font:
            kept = [f"{name}:{value}" for name, value in _properties(element).items() if name != "font-family"]
            element.set("style", ";".join(kept))
        if not element.get("style", "-"):
            del element.attrib["style"]
        if element.tag not in TEXTS:
            element.text = (element.text or "").strip()
    root[:] = _slim(root)
    root.attrib = {
        "viewBox": root.attrib["viewBox"],
        "style": f"--width:{width * ZOOM * 96 / 72:.0f}px" + (f";font-family:{font}" if font else ""),
        "role": "img",
        "aria-label": caption,
    }
    return Markup(ElementTree.tostring(root, encoding="unicode").replace(" />", "/>"))


def _properties(element: ElementTree.Element) -> dict[str, str]:
    """Return the style of an element, by property."""
    pairs = (pair.partition(":") for pair in element.get("style", "").split(";") if pair.strip())
    return {name.strip(): value.strip() for name, _, value in pairs}


def _common_font(root: ElementTree.Element) -> str:
    """Return the font family of most texts of a figure, "" where none has one."""
    fonts = Counter(_properties(element).get("font-family", "") for element in root.iter(f"{SVG}text"))
    del fonts[""]
    return fonts.most_common(1)[0][0] if fonts else ""


def _attribute(tag: str, key: str, value: str, ids: dict[str, str]) -> str:
    """Return an attribute's value with its ids renamed and without needless characters."""
    if key == "id":
        return ids[value]
    if key == "d":
        return shortened(value)
    if key in COORDINATES and tag not in TEXTS:  # letters snap to whole pixels, so a small shift of them shows
        return re.sub(
            r"-?\d*\.?\d+(?:e-?\d+)?", lambda number: f"{float(number[0]):.2f}".rstrip("0").rstrip("."), value
        )
    if key == "style":
        value = re.sub(r"([:;]) +", r"\1", value)
        value = re.sub(r"#(000000|ffffff|dddddd)\b", lambda colour: PAGE_COLOURS[colour[0]], value)
    return re.sub(r"(^|url\()#([^)]+)", lambda link: f"{link[1]}#{ids.get(link[2], link[2])}", value)


def _slim(parent: ElementTree.Element) -> list[ElementTree.Element]:
    """Return the children of an element; common styles move to their group, groups without attributes vanish."""
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
    return _with_grids_joined(kept)


def _with_grids_joined(children: list[ElementTree.Element]) -> list[ElementTree.Element]:
    """Join the lines of each panel's grid, which hide nothing and are hidden by all else, in the first of them."""
    first: dict[str, ElementTree.Element] = {}
    kept = []
    for child in children:
        grid = child.tag == "path" and f"stroke:{PAGE_COLOURS[GRID]}" in child.get("style", "") and child.get(CLIP)
        if grid and grid in first:
            first[grid].set("d", first[grid].attrib["d"] + child.attrib["d"].replace("m", "M", 1))
            continue
        if grid:
            child.set("d", child.attrib["d"].replace("m", "M", 1))
            first[grid] = child
        kept.append(child)
    return kept


def _hoist(group: ElementTree.Element) -> None:
    """Move a style that all shapes of a group share to the group; the shapes inherit its properties."""
    shapes = [child for child in group if child.tag != "defs"]
    styles = {shape.get("style", "") for shape in shapes}
    if len(shapes) > 1 and len(styles) == 1 and "style" not in group.attrib:
        style = styles.pop()
        if style and all(pair.lstrip().startswith(("fill", "stroke")) for pair in style.split(";")):
            group.set("style", style)
            for shape in shapes:
                del shape.attrib["style"]


def _widest(views: list[View]) -> int:
    """Return the number of columns of the page's widest table."""
    items = [item for outer in views for view in (outer, *outer.views) for item in view.items]
    return max((len(item.grid.header) for item in items), default=0)


def _asset(name: str) -> Markup:
    """Return one of the page's own files, as trusted text."""
    return Markup(resources.files("bench.report").joinpath(name).read_text(encoding="utf-8"))
