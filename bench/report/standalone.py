"""Write a page of sections alone, without a study: one file that loads nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from bench.helpers.atomic import replacing
from bench.helpers.text import file_name, free, slug
from bench.plots import style
from bench.report.drawing import draw
from bench.report.page import Item, View, inline, render
from bench.report.parts import Part, Section, Table


def write_page(path: Path, title: str, lead: str, sections: Sequence[Section]) -> Path:
    """Write sections with their tables and figures as one HTML file, and return its path.

    Raises:
        BenchError: where it cannot be written.
    """
    taken: set[str] = set()

    def item(part: Part) -> Item:
        name = free(file_name(part.name), taken)
        taken.add(name)
        if isinstance(part, Table):
            return Item(name, [], part)
        return Item(name, [], part, inline(draw(part.figure, pdf=False).svg.decode(), name, part.caption))

    def view(section: Section) -> View:
        anchor = free(slug(section.title) or "part", taken)
        taken.add(anchor)
        return View(
            anchor, section, [item(part) for part in section.items], [view(inner) for inner in section.sections], []
        )

    with style.context(), replacing(path) as temporary:
        temporary.write_text(render(title, lead, [view(section) for section in sections]), encoding="utf-8")
    return path
