"""Write the report of a study's folder, or of several folders compared with each other."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path
from types import ModuleType
from typing import Any

import pandas as pd
from threadpoolctl import threadpool_limits

from bench.errors import BenchError, nearest
from bench.helpers.console import OnStep
from bench.helpers.parsing import parse_json
from bench.helpers.text import file_name, free, slug
from bench.plots import style
from bench.plugins import registry
from bench.report.answer import answer
from bench.report.drawing import Drawer, Drawing, draw
from bench.report.findings import CROWD, Findings
from bench.report.interactive import interactive
from bench.report.latex import to_latex
from bench.report.methods import methods
from bench.report.page import Item, View, inline, render
from bench.report.parts import Figure, Part, Section, Table
from bench.report.replication import each_problem
from bench.report.sections import CLOSING, OPENING
from bench.report.wording import count
from bench.results.results import Results
from bench.storage.folder import ANSWER
from bench.study.rope import Rope
from bench.study.selection import Dimensions, Patterns
from bench.study.targets import Targets

PAGE, MANIFEST = "report.html", ".report.json"
TABLES, FIGURES = "tables", "figures"
ANCHOR = "part"  # of the sections, part.verdict and so on; a figure of this name would have ids like these
PROBLEM = "problem"  # of the sections on one problem
FEW = 4  # problems up to which other processes would take longer to start than to draw
COMPARISONS = Path("results") / "comparisons"
WHOLE = {
    "trials": "All trials, one row a trial.",
    "cells": "All cells: trials, failures and statistics of the objective value.",
    "tests": f"The tests of every pair of optimizers, at most of the {CROWD} best, on every problem.",
    "controls": "The trials of controls, which no other table, figure or test has but that of the same conditions.",
    "running-times": "The expected running times (ERT) of every optimizer on every problem, with their spread.",
}
"""The tables of a whole study, by name, with their descriptions; no other part has these names."""


def write_report(
    path: str | PathLike[str],
    *others: str | PathLike[str],
    output: str | PathLike[str] | None = None,
    n_jobs: int = -1,
    targets: Any = None,
    rope: Any = None,
    beside_best: bool = False,
    reference: str | None = None,
    optimizers: Patterns = None,
    problems: Patterns = None,
    dimensions: Dimensions = None,
    versions: Sequence[str] = (),
    on_progress: OnStep | None = None,
) -> Path:
    """Write ``report.html``, ``tables/``, ``figures/`` and the methods' text, and return the page's path.

    Several folders are compared as one study (:class:`bench.Results`). The same results give the same bytes. A
    plug-in's section that fails becomes a warning on the page, and so do damaged trials, which are left out. Files
    that only an earlier report had are removed.

    Args:
        path: a study's folder.
        others: further folders to compare with it.
        output: the folder to write into; by default the study's own, and ``results/comparisons/NAMES`` for several.
        n_jobs: processes that draw figures, -1 for one a core; the files do not depend on it.
        targets: what counts as reached, other than the study's own (:meth:`bench.study.targets.Targets.read`).
        rope: differences that count as equal, other than the study's own (:class:`bench.study.rope.Rope`).
        beside_best: whether the running times of the best algorithms of 2009 stand beside those of the optimizers
            (:mod:`bench.formats.coco.best2009`; it needs the extra ``coco``).
        reference: the label of the optimizer that the competition's table compares with each other one.
        optimizers: labels or patterns of the only optimizers to show (:meth:`bench.Results.select`). The page, the
            methods and the answer say what was left out, and a selection needs an ``output`` of its own.
        problems: likewise of problems.
        dimensions: the only dimensions of problems to show.
        versions: labels or patterns of optimizers whose earlier versions stand beside them, as ``label@1``.
        on_progress: called before every step.

    Raises:
        BenchError: when a folder holds no study or no store, the folders cannot be compared, ``targets`` or ``rope``
            are none, the best of 2009 is of other problems, the study has no optimizer ``reference``, nothing has a
            pattern or a dimension that is selected, a selection has no ``output``, or that cannot be written or holds
            another study.
    """
    chosen = None if targets is None else Targets.read(targets, "the targets of a report")
    equal = None if rope is None else Rope.read(rope, "the rope of a report")
    results = Results(path, *others, versions=versions)
    if (optimizers, problems, dimensions) != (None, None, None):
        results = results.select(optimizers=optimizers, problems=problems, dimensions=dimensions)
    findings = Findings(results, chosen, equal, beside_best, reference)
    if reference is not None and reference not in findings.trials.optimizers:
        raise BenchError(
            f"the study has no optimizer {reference!r} to refer to{nearest(reference, findings.trials.optimizers)}"
        )
    findings.anytime.check_targets()
    folder = _folder(results, None if output is None else Path(output))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # Threads of BLAS gain nothing on matrices as small as these, and wait for each other where cores are busy.
        with threadpool_limits(limits=1), Drawer(n_jobs if len(results.study.problems) > FEW else 1) as drawer:
            page = _Report(findings, folder, drawer, on_progress or (lambda *_: None)).write()
    except OSError as error:
        raise BenchError(f"the report cannot be written into {folder}: {error.strerror}") from error
    results.note_stores()
    return page


def _folder(results: Results, output: Path | None) -> Path:
    paths = results.paths
    own = {path.resolve() for path in paths}
    if results.partial and (output is None or output.resolve() in own):
        raise BenchError(
            "a selection is another report than that of the whole folder, which it would replace; give it a folder of "
            "its own by --output"
        )
    if output is None:
        return paths[0] if len(paths) == 1 else COMPARISONS / "-".join(map(file_name, results.names))
    if len(paths) == 1 and output.resolve() == paths[0].resolve():
        return output
    if (output / "study.toml").exists():
        raise BenchError(f"{output} is the folder of a study, whose own report would be lost; give another --output")
    if output.is_dir() and any(output.iterdir()) and not (output / MANIFEST).exists():
        raise BenchError(f"{output} holds other files and no report of ours; give an --output of its own")
    return output


class _Report:
    """A report in progress: the views so far, the files written and the names taken."""

    def __init__(self, findings: Findings, folder: Path, drawer: Drawer, on_progress: OnStep) -> None:
        self.results = findings.results
        self.findings = findings
        self.folder = folder
        self.drawer = drawer
        self.views: list[View] = []
        self.files: dict[str, str] = {}
        self.names = {*WHOLE, ANCHOR, PROBLEM}
        self.anchors: set[str] = set()
        self.problems: dict[str, str] = {}  # the anchor of the section on each problem
        self._on_progress = on_progress
        self._done = 0
        self._steps = 0

    def write(self) -> Path:
        study = self.findings.study
        if not (self.folder / MANIFEST).exists():  # marks the folder as a report's, also after an interruption
            (self.folder / MANIFEST).write_text("[]", encoding="utf-8")
        plugged = sorted(registry.entries("report_sections"))
        self._steps = len(OPENING) + len(plugged) + len(CLOSING) + len(study.problems) + 1
        with style.context():
            opening = [self.prepare(part) for part in OPENING]
            middle = [self.prepare_plugin(name) for name in plugged]
            closing = [self.prepare(part) for part in CLOSING]
            self.drawer.help()
            for section in filter(None, opening):
                self.append(section)
            for name, sections in zip(plugged, middle, strict=True):
                self.append_plugin(name, sections)
            for section in filter(None, closing):
                self.append(section)
        self.add_downloads()
        lead = (
            f"Study {study.name}: {count(len(study.optimizers), 'optimizer')} on "
            f"{count(len(study.problems), 'problem')}, "
            f"{each_problem(self.findings.trials.replications, at_most=study.trials if study.looks else 0)}, "
            f"{'at most ' * bool(study.imported)}{study.budget_words} a trial."
        )
        lead = f"{lead} {self.findings.selection}".rstrip()
        further = interactive(self.findings)
        lines = answer(self.findings, opening[0]) if opening[0] is not None else {}
        self.save(ANSWER, json.dumps(lines, ensure_ascii=False, indent=1), "The answer in a few lines, as JSON.")
        html = render(study.title or study.name, lead, self.views, self.problems, further)
        page = self.save(PAGE, html, "This page.")
        self.clean()
        return page

    def prepare(self, part: ModuleType) -> Section | None:
        """Return a part's section, whose figures are then drawn while others are prepared; None where it has none."""
        self.step(part.TITLE)
        section: Section | None = part.section(self.findings)
        if section is not None:
            self.begin(section)
        return section

    def begin(self, section: Section) -> None:
        """Have the figures of a section and of its subsections drawn."""
        for part in (section, *section.sections):
            figures = [item.figure for item in part.items if isinstance(item, Figure)]
            self.drawer.begin(figures, pdf=self.printed(part))

    def printed(self, section: Section) -> bool:
        """Whether a section is also written as LaTeX and PDF: of many problems, only the parts on all of them are."""
        return not (section.problem and self.findings.trials.many)

    def prepare_plugin(self, name: str) -> list[Section] | Exception:
        """Return the sections of a plug-in, or what it raises."""
        self.step(f"Section {name}")
        prepared = []
        try:
            sections: Callable[[Results], list[Section]] = registry.load("report_sections", name)
            for section in sections(self.results):
                self.begin(section)
                prepared.append(section)
        except Exception as error:
            return error
        return prepared

    def append(self, section: Section) -> None:
        self.views.append(self.view(section, self.anchor(ANCHOR, section.title)))

    def anchor(self, kind: str, title: str) -> str:
        """Return the id of a section, which stays the same as long as its title does."""
        name = free(f"{kind}.{slug(title) or 'part'}", self.anchors)
        self.anchors.add(name)
        return name

    def append_plugin(self, name: str, sections: list[Section] | Exception) -> None:
        """Add the sections of a plug-in, or a warning where it raises, which costs no other part."""
        views, files = list(self.views), dict(self.files)
        try:
            if isinstance(sections, Exception):
                raise sections
            for section in sections:
                self.append(section)
        except Exception as error:
            for path in self.files.keys() - files:
                (self.folder / path).unlink()
            self.views, self.files = views, files
            reason = f"The report section {name!r} failed and is left out: {type(error).__name__}: {error}"
            self.append(Section(f"Section {name}", warnings=(reason,)))

    def add_downloads(self) -> None:
        """Add the last part, the list of all files."""
        (self.folder / TABLES).mkdir(exist_ok=True)
        findings = self.findings
        frames = (
            self.results.frame,
            findings.final.summary,
            findings.display.written_pairs,
            self.results.controls,
            findings.anytime.target_set.in_unit(findings.anytime.running_times, findings.anytime.target_set.unit),
        )
        for (name, about), frame in zip(WHOLE.items(), frames, strict=True):
            if name in ("controls", "running-times") and not len(frame):
                continue  # no control was run, or no trial left a trace
            path = f"{TABLES}/{name}.csv"
            save_csv(frame, self.folder / path, index=False)
            pooled = name == "cells" and findings.trials.precisions
            self.files[path] = f"{about[:-1]}, precisions where instances are pooled." if pooled else about
        if len(self.results.frame):
            stated = methods(self.findings)
            self.save("methods.md", stated.markdown, "The methods as Markdown.")
            self.save("methods.tex", stated.latex, "The methods as LaTeX.")
            self.save("references.bib", stated.bibtex, "The works cited in the methods.")
        text = (
            "Paths are relative to this page. CSV files have all digits, also where the page shows fewer. Figures are "
            f"{style.COLUMN} or {style.TEXT} in wide, for one or both columns of a paper."
        )
        section = Section("Downloads", (text,), on_demand=True)
        self.step(section.title)
        anchor = self.anchor(ANCHOR, section.title)
        self.views.append(View(anchor, section, [], [], sorted(self.files.items())))

    def view(self, section: Section, anchor: str) -> View:
        printed = self.printed(section)
        view = View(anchor, section, [self.item(part, printed=printed) for part in section.items], [], [])
        for subsection in section.sections:
            inner = self.anchor(PROBLEM if subsection.problem else anchor, subsection.problem or subsection.title)
            if subsection.problem:
                self.step(f"{section.title}: {subsection.title}")
                self.problems.setdefault(subsection.problem, inner)
            view.views.append(self.view(subsection, inner))
        return view

    def item(self, part: Part, *, printed: bool) -> Item:
        name = free(file_name(part.name), self.names)
        self.names.add(name)
        if isinstance(part, Table):
            files = save_table(part, self.folder, name, latex=printed, study=self.results.study.name)
            item = Item(name, files, part)
        else:
            svg, files = save_figure(part, self.folder, name, self.drawer.finish(part.figure, pdf=printed))
            item = Item(name, files, part, inline(svg, name, part.caption))
        self.files |= dict.fromkeys(files, re.split(r"(?<!Fig)\. ", part.caption)[0].rstrip(".") + ".")
        _ = item.grid  # a frame that the page cannot show raises here, within its own section
        return item

    def save(self, name: str, text: str, about: str) -> Path:
        (self.folder / name).write_text(text, encoding="utf-8", newline="\n")
        self.files[name] = about
        return self.folder / name

    def step(self, title: str) -> None:
        self._on_progress(title, self._done, self._steps)
        self._done += 1
        self._steps = max(self._steps, self._done)

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


def save_table(table: Table, folder: Path, name: str, *, latex: bool = True, study: str = "") -> list[str]:
    """Write a table as CSV (full precision) and, on request, LaTeX; return the paths relative to ``folder``.

    The label of the LaTeX begins with the name of the study, as a paper may have the same table of several.
    """
    (folder / TABLES).mkdir(exist_ok=True)
    paths = [f"{TABLES}/{name}.{kind}" for kind in (("csv", "tex") if latex else ("csv",))]
    if table.data is None:
        save_csv(table.frame, folder / paths[0], index=table.has_index)
    else:
        save_csv(table.data, folder / paths[0], index=False)
    if latex:
        text = to_latex(table, f"{study}-{name}" if study else name)
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
