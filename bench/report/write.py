"""Write the sections of a report into a folder: one page, and every table and figure as files."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from bench.helpers.console import OnStep
from bench.helpers.parsing import parse_json
from bench.helpers.text import file_name, free, slug
from bench.plots import style
from bench.report.documentation import GUIDES
from bench.report.drawing import Drawer, Drawing, draw
from bench.report.latex import ONE_COLUMN, Layout, to_latex
from bench.report.page import Item, View, file_rows, inline, render, render_guide
from bench.report.parts import Figure, File, Part, Section, Table, warning

PAGE, MANIFEST, CONTENTS = "report.html", ".report.json", "CONTENTS.md"
TABLES, FIGURES = "tables", "figures"
ANCHOR = "part"  # of the sections, part.answer and so on; a figure of this name would have ids like these


@dataclass(frozen=True)
class Chapter:
    """Sections that are made together; if one fails, a warning takes their place.

    Attributes:
        name: of the plug-in that makes them, for the warning.
        title: printed while they are made.
        sections: makes them. A section whose title another chapter has stands at the place of that one, and sections
            of one title are one section of the page.
    """

    name: str
    title: str
    sections: Callable[[], list[Section]]


class Draft:
    """A report in progress: the views so far, the files written and the names taken.

    Args:
        folder: the folder to write into, which exists.
        drawer: draws the figures.
        study: a name that the labels of LaTeX tables begin with.
        layout: the columns that the LaTeX tables are written for.
        on_step: called before every step.
    """

    def __init__(
        self,
        folder: Path,
        drawer: Drawer,
        *,
        study: str,
        on_step: OnStep,
        layout: Layout = ONE_COLUMN,
    ) -> None:
        self.folder = folder
        self.drawer = drawer
        self.study = study
        self.layout = layout
        self.views: list[View] = []
        self.files: dict[str, str] = {}
        self.names = {ANCHOR}
        self.anchors: set[str] = set()
        self._on_step = on_step

    def write(self, title: str, lead: str, chapters: Sequence[Chapter], short: Callable[[Section], File]) -> Path:
        """Write all files and return the path of the page; ``short`` makes a file of its first section."""
        if not (self.folder / MANIFEST).exists():  # marks the folder as a report's, also after an interruption
            (self.folder / MANIFEST).write_text("[]", encoding="utf-8")
        steps, prepared = len(chapters) + 1, []
        with style.context():
            for done, chapter in enumerate(chapters):
                self._on_step(chapter.title, done, steps)
                prepared.append(self.prepare(chapter))
            self.drawer.help()
            places = {chapter.title: place for place, chapter in enumerate(chapters)}
            for place, (chapter, made) in enumerate(zip(chapters, prepared, strict=True)):
                self.append_all(chapter, made)
                for view in self.views:
                    places.setdefault(view.section.title, place)
        self.views.sort(key=lambda view: places[view.section.title])
        file = short(self.views[0].section)
        self.save(file.path, file.content, file.about)
        for name, about in GUIDES.items():
            self.save(f"{name}.html", render_guide(name), about)
        self.save(CONTENTS, contents(title, self.files), "These files.")
        listed = file_rows(self.files)
        self.views = [replace(view, files=listed) if view.section.lists_files else view for view in self.views]
        self._on_step("The page", len(chapters), steps)
        page = self.save(PAGE, render(title, lead, self.views, guides=True), "This page.")
        self.clean()
        return page

    def prepare(self, chapter: Chapter) -> list[Section] | Exception:
        """Return a chapter's sections, whose figures are then drawn while others are prepared, or what it raises."""
        try:
            sections = chapter.sections()
            for section in sections:
                self.begin(section)
        except Exception as error:  # a plug-in may raise anything
            return error
        stems = [file.stem.rpartition("/") for section in sections for file in section.files]
        self.names |= {stem for folder, _, stem in stems if folder == TABLES}
        return sections

    def begin(self, section: Section) -> None:
        """Have the figures of a section and of its subsections drawn."""
        for part in (section, *section.sections):
            figures = [item.figure for item in part.items if isinstance(item, Figure)]
            self.drawer.begin(figures)

    def anchor(self, kind: str, title: str) -> str:
        """Return the id of a section, which stays the same as long as its title does."""
        name = free(f"{kind}.{slug(title) or 'part'}", self.anchors)
        self.anchors.add(name)
        return name

    def append_all(self, chapter: Chapter, prepared: list[Section] | Exception) -> None:
        """Add a chapter, or a warning where it raised, which costs no other part; a full disk raises OSError."""
        views, files = list(self.views), dict(self.files)
        error = prepared if isinstance(prepared, Exception) else None
        if isinstance(prepared, list):
            try:
                for section in prepared:
                    self.append(section)
                    for file in section.files:
                        self.save(file.path, file.content, file.about)
            except OSError:
                raise
            except Exception as raised:
                error = raised
        if error is not None:
            for path in self.files.keys() - files:
                (self.folder / path).unlink()
            self.views, self.files = views, files
            reason = f"The report section {chapter.name!r} failed and is left out: {type(error).__name__}: {error}"
            self.append(Section(chapter.title, lines=(warning("section failed", reason),)))

    def append(self, section: Section) -> None:
        """Add a section, or its parts to the section of the same title."""
        for place, same in enumerate(self.views):
            if same.section.title == section.title:
                added = self.view(section, same.anchor)
                whole = same.section.joined(section)
                self.views[place] = View(same.anchor, whole, same.items + added.items, same.views + added.views, [])
                return
        self.views.append(self.view(section, self.anchor(ANCHOR, section.title)))

    def view(self, section: Section, anchor: str) -> View:
        """Return a section with its files written, ready for the page."""
        view = View(anchor, section, [self.item(part) for part in section.items], [], [])
        for subsection in section.sections:
            view.views.append(self.view(subsection, self.anchor(anchor, subsection.title)))
        return view

    def item(self, part: Part) -> Item:
        """Write the files of a table or figure, and return it for the page."""
        name = free(file_name(part.name), self.names)
        self.names.add(name)
        if isinstance(part, Table):
            files = save_table(part, self.folder, name, layout=self.layout, study=self.study)
            item = Item(name, files, part)
        else:
            drawing = self.drawer.finish(part.figure)
            svg, files = save_figure(part, self.folder, name, drawing)
            if isinstance(part.shown, Table):
                files += self.item(part.shown).files
            item = Item(name, files, part, inline(svg, name, part.caption))
        self.files |= dict.fromkeys(files, re.split(r"(?<!Fig)\. ", part.caption)[0].rstrip(".") + ".")
        _ = item.grid  # a frame that the page cannot show raises here, within its own section
        return item

    def save(self, name: str, content: str | pd.DataFrame, about: str) -> Path:
        """Write a file of text, or of a frame as CSV, and list it."""
        path = self.folder / name
        path.parent.mkdir(exist_ok=True)
        if isinstance(content, str):
            path.write_text(content, encoding="utf-8", newline="\n")
        else:
            save_csv(content, path, index=False)
        self.files[name] = about
        return path

    def clean(self) -> None:
        """Remove the files that only an earlier report wrote, and record those of this one."""
        manifest = self.folder / MANIFEST
        try:
            before = parse_json(manifest.read_bytes())
        except (OSError, ValueError):
            before = []
        for name in map(str, before if isinstance(before, list) else []):
            path = self.folder / name
            if re.fullmatch(rf"({TABLES}|{FIGURES})/[\w.-]+", name) and name not in self.files and path.is_file():
                path.unlink()
        manifest.write_text(json.dumps(sorted(self.files), indent=0), encoding="utf-8")


def contents(title: str, files: Mapping[str, str]) -> str:
    """Return, as Markdown, what each file of a report is: files of one name and several formats in one line."""
    rows = [f"| `{row.stem}` | {', '.join(row.endings)} | {row.about} |" for row in file_rows(files)]
    head = [f"# {title}", "", "Open `report.html` first.", "", "| file | formats | content |", "|-|-|-|"]
    return "\n".join([*head, *rows, ""])


def save_table(table: Table, folder: Path, name: str, *, layout: Layout = ONE_COLUMN, study: str = "") -> list[str]:
    """Write a table as CSV (full precision) and on its request as LaTeX; return the paths relative to ``folder``.

    The label of the LaTeX begins with the name of the study, as a paper may have the same table of several.
    """
    (folder / TABLES).mkdir(exist_ok=True)
    paths = [f"{TABLES}/{name}.{kind}" for kind in (("csv", "tex") if table.latex else ("csv",))]
    if table.data is None:
        save_csv(table.frame, folder / paths[0], index=table.has_index)
    else:
        save_csv(table.data, folder / paths[0], index=False)
    if table.latex:
        text = to_latex(table, f"{study}-{name}" if study else name, layout)
        (folder / paths[1]).write_text(text, encoding="utf-8", newline="\n")
    return paths


def save_figure(figure: Figure, folder: Path, name: str, drawing: Drawing | None = None) -> tuple[str, list[str]]:
    """Write a drawn figure and its data as CSV; return the SVG's text and the paths relative to ``folder``."""
    (folder / FIGURES).mkdir(exist_ok=True)
    drawn = draw(figure.figure) if drawing is None else drawing
    paths = []
    for kind, content in drawn._asdict().items():
        if content is not None:
            paths.append(f"{FIGURES}/{name}.{kind}")
            (folder / paths[-1]).write_bytes(content)
    paths.append(f"{FIGURES}/{name}.csv")
    save_csv(figure.data, folder / paths[-1], index=False)
    return drawn.svg.decode(), paths


def save_csv(frame: pd.DataFrame, path: Path, *, index: bool) -> None:
    """Write a frame as CSV with every digit, the same bytes on every system."""
    frame.to_csv(path, index=index, lineterminator="\n", encoding="utf-8")
