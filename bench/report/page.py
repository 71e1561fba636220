"""The page: one HTML file without scripts or anything to fetch."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from bench.report.parts import Figure, Table

SVG, XLINK = "http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"


@dataclass(frozen=True)
class Item:
    """A table, or a figure with its SVG, and the files it was written to."""

    anchor: str
    files: list[str]
    table: Table | None = None
    figure: Figure | None = None
    svg: Markup | None = None


@dataclass(frozen=True)
class View:
    """A section ready to be shown."""

    anchor: str
    title: str
    text: tuple[str, ...]
    warnings: tuple[str, ...]
    items: list[Item]


def render(title: str, lead: str, views: list[View]) -> str:
    """Return the page as HTML; all text is escaped by the template."""
    environment = Environment(
        loader=PackageLoader("bench.report", ""), autoescape=True, undefined=StrictUndefined, keep_trailing_newline=True
    )
    return environment.get_template("page.html.j2").render(title=title, lead=lead, views=views)


def inline(svg: str, name: str, caption: str) -> Markup:
    """Return a figure's SVG for the page: no metadata, no fixed size, its ids made its own, its caption as label."""
    root = ElementTree.fromstring(svg)
    for metadata in root.findall(f"{{{SVG}}}metadata"):
        root.remove(metadata)
    for size in ("width", "height"):
        root.attrib.pop(size, None)
    root.attrib |= {"role": "img", "aria-label": caption}
    for element in root.iter():
        for key, value in element.attrib.items():
            if key == "id":
                element.set(key, f"{name}-{value}")
            elif key in ("href", f"{{{XLINK}}}href") and value.startswith("#"):
                element.set(key, f"#{name}-{value[1:]}")
            elif "url(#" in value:
                element.set(key, value.replace("url(#", f"url(#{name}-"))
    ElementTree.register_namespace("", SVG)
    ElementTree.register_namespace("xlink", XLINK)
    return Markup(ElementTree.tostring(root, encoding="unicode"))
