"""Write the report of a study's folder."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from pathlib import Path

from bench import plugins
from bench.errors import BenchError
from bench.report import style
from bench.report.builtin import closing_sections, opening_sections
from bench.report.files import file_name, save_figure, save_table
from bench.report.findings import Findings
from bench.report.page import Item, View, inline, render
from bench.report.parts import Part, Section, Table
from bench.report.words import count
from bench.results import Results

PAGE = "report.html"


def write_report(path: str | PathLike[str]) -> Path:
    """Write ``report.html``, ``tables/`` and ``figures/`` into a study's folder and return the page's path.

    The same results give the same bytes. A plug-in's section that fails becomes a warning on the page.

    Raises:
        BenchError: when the folder holds no study or no store, or cannot be written.
    """
    results = Results(path)
    try:
        return _Report(results, Path(path)).write()
    except OSError as error:
        raise BenchError(f"the report cannot be written into {path}: {error.strerror}") from error


class _Report:
    """A report under way: the views so far and the names taken."""

    def __init__(self, results: Results, folder: Path) -> None:
        self.results = results
        self.folder = folder
        self.views: list[View] = []
        self.names: set[str] = set()

    def write(self) -> Path:
        study, findings = self.results.study, Findings(self.results)
        with style.context():
            self.add(opening_sections(findings))
            for name in sorted(plugins.entries("report_sections")):
                self.add_plugin(name)
            self.add(closing_sections(findings))
        lead = (
            f"Study {study.name}: {count(len(study.optimizers), 'optimizer')} on "
            f"{count(len(study.problems), 'problem')}, {count(study.trials, 'trial')} each, "
            f"{count(study.budget, 'evaluation')} a trial."
        )
        page = self.folder / PAGE
        page.write_text(render(study.title or study.name, lead, self.views), encoding="utf-8", newline="\n")
        return page

    def add(self, sections: list[Section]) -> None:
        for section in sections:
            self.views.append(self.view(section))

    def add_plugin(self, name: str) -> None:
        """Add a plug-in's sections, or a warning: a stranger's code may raise anything, and costs only its own part."""
        before = len(self.views)
        try:
            sections: Callable[[Results], list[Section]] = plugins.load("report_sections", name)
            self.add(sections(self.results))
        except Exception as error:
            del self.views[before:]
            reason = f"The report section {name!r} failed and is left out: {type(error).__name__}: {error}"
            self.add([Section(f"Section {name}", warnings=(reason,))])

    def view(self, section: Section) -> View:
        items = [self.item(part) for part in section.items]
        return View(f"section-{len(self.views) + 1}", section.title, section.text, section.warnings, items)

    def item(self, part: Part) -> Item:
        name = self.unique(part.name)
        if isinstance(part, Table):
            return Item(name, save_table(part, self.folder, name), table=part)
        svg, files = save_figure(part, self.folder, name)
        return Item(name, files, figure=part, svg=inline(svg, name, part.caption))

    def unique(self, name: str) -> str:
        """Return a safe name that nothing else of this report has."""
        safe = stem = file_name(name)
        number = 1
        while safe in self.names:
            number += 1
            safe = f"{stem}-{number}"
        self.names.add(safe)
        return safe
