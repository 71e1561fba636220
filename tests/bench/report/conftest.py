"""A page with one of everything, its reader, and studies to report on."""

import re
from html.parser import HTMLParser

import numpy as np
import pandas as pd
import pytest

from bench import Trace
from bench.columns import packed
from bench.report.page import Item, View, inline, render
from bench.report.parts import Card, Figure, Section, Table
from bench.storage.folder import Folder
from bench.study import Entry, Study

SVG = """<?xml version="1.0" encoding="utf-8"?>
<svg xmlns:xlink="http://www.w3.org/1999/xlink" width="252pt" height="144pt" viewBox="0 0 252 144"
  xmlns="http://www.w3.org/2000/svg" version="1.1">
 <metadata><rdf>Matplotlib</rdf></metadata>
 <defs><style type="text/css">*{stroke-linejoin: round; stroke-linecap: butt}</style></defs>
 <g id="figure_1">
  <g id="axes_1" clip-path="url(#p1)">
   <defs><path id="m1" d="M 0 3  C 0.795609 3 1.55874 2.683901 2.12132 2.12132  z " style="stroke: #0072b2"/></defs>
   <g><use xlink:href="#m1" x="10.123456" y="20.987654" style="fill: #0072b2; stroke: #0072b2"/>
      <use xlink:href="#m1" x="30" y="40.5" style="fill: #0072b2; stroke: #0072b2"/></g>
  </g>
  <g id="text_1"><text style="font: 8px sans-serif" x="126.004" y="72">two <tspan>words</tspan> here</text></g>
 </g>
 <defs><clipPath id="p1"><rect x="0" y="0" width="252" height="144"/></clipPath></defs>
</svg>"""


@pytest.fixture(scope="session")
def item():
    """Return an item of a part, as the report's writer makes it."""

    def make(part):
        if isinstance(part, Table):
            return Item(part.name, [f"tables/{part.name}.csv", f"tables/{part.name}.tex"], part)
        files = [f"figures/{part.name}.{kind}" for kind in ("svg", "pdf", "csv")]
        return Item(part.name, files, part, inline(SVG, part.name, part.caption))

    return make


@pytest.fixture(scope="session")
def view(item):
    """Return a view of a section, as the report's writer makes it."""

    def make(anchor, section, files=()):
        inner = [make(f"{anchor}-{number}", each) for number, each in enumerate(section.sections, 1)]
        return View(anchor, section, [item(part) for part in section.items], inner, list(files))

    return make


@pytest.fixture(scope="session")
def views(view):
    """A verdict, tables to sort and to filter, figures with short and long data, datasets, a text to copy and files."""
    cards = (
        Card("What may be claimed", ("cma-es is ranked first on 18 of 18 problems.",), "claim"),
        Card(
            "What may not",
            ("No optimizer is shown to be equal to another.", "Shifts may be missed."),
            "limit",
            folded=True,
        ),
    )
    numbers = [1234.5, np.inf, 0.5, np.nan, -2.0, 1e-5, 99.0, 1200.0, 3.0, 7.0, 8.0, 9.0]
    wide = pd.DataFrame(
        {
            "name": [f"problem-{i}" for i in range(1, 13)],
            "value": numbers,
            "p": ["0.03", "<1e-4", "0.0002", "–", "1.2e-05", "1", "0.5", "0.6", "0.7", "0.8", "0.9", "0.99"],
            "mixed": ["1,234.5", "−0.5", "-3e+02", "∞", "−∞", "12 %", "3.1 to 4.2", "0", "", ">20", "+7", "20"],
            "remark": ["a long remark on one trial that failed and so scores infinity " * 2, *["short"] * 11],
        }
        | {f"column {i}": np.arange(12.0) for i in range(9)}
    )
    marks = pd.DataFrame({"b": ["a", "ab"]}, index=pd.Index(["p", "q"], name="problem"))
    pair = pd.DataFrame({"a": [1, 22], "b": [3.5, 4.5]}, index=marks.index)
    matrix = Table(
        "matrix", "Medians.", pair, bold=pair < 2, italic=pair > 4, marks=marks, note="Letters: not separable."
    )
    short = Figure("short", "A figure of few numbers.", None, pd.DataFrame({"x": [1, 2], "y": [3.0, 4.0]}))
    long = Figure("long", "A figure of many.", None, pd.DataFrame({"x": np.arange(1234), "y": np.arange(1234) / 7}))
    datasets = tuple(Section(f"dataset {i}", (f"About dataset {i}.",)) for i in range(1, 4))
    return [
        view("section-1", Section("Verdict", ("A sentence.",), cards=cards, warnings=("Few trials.", "Odd ones."))),
        view("section-2", Section("Comparison", items=(matrix, Table("wide", "Everything.", wide)))),
        view("section-3", Section("Curves", items=(short, long))),
        view("section-4", Section("Datasets", sections=datasets)),
        view("section-5", Section("Methods", code="@book{a,\n  title = {<b>}\n}" + " " * 200 + "end")),
        view(
            "section-6",
            Section("Downloads"),
            [
                ("figures/a b#.pdf", "A figure."),
                ("figures/a b#.svg", "A figure."),
                ("report.html", "this page"),
                ("tables/trials.csv", "every trial"),
            ],
        ),
    ]


@pytest.fixture(scope="session")
def page(views):
    """The page of these views."""
    return render("A <report>", "Five optimizers & more.", views)


VOID = {"meta", "link", "input", "img", "br", "hr"}


class Document(HTMLParser):
    """A page's elements as (tag, attributes, text within), tags checked to be closed in order."""

    def __init__(self, html):
        super().__init__()
        self.html, self.elements, self.open, self.words = html, [], [], []
        self.feed(html)
        self.close()
        assert not self.open
        self.tags = [tag for tag, _, _ in self.elements]
        self.text = " ".join(" ".join(self.words).split())  # what a reader sees, and the title

    def handle_starttag(self, tag, attrs):
        self.handle_startendtag(tag, attrs)
        if tag not in VOID:
            self.open.append(self.elements[-1])

    def handle_startendtag(self, tag, attrs):
        assert len(dict(attrs)) == len(attrs)
        self.elements.append((tag, dict(attrs), []))

    def handle_endtag(self, tag):
        assert self.open.pop()[0] == tag

    def handle_data(self, data):
        for _, _, text in self.open:
            text.append(data)
        if self.open and self.open[-1][0] not in ("style", "script"):
            self.words.append(data)

    def texts(self, tag, **attributes):
        return [
            " ".join("".join(text).split())
            for name, attrs, text in self.elements
            if name == tag and attributes.items() <= attrs.items()
        ]

    def values(self, attribute):
        return [attrs[attribute] for _, attrs, _ in self.elements if attribute in attrs]

    def check_that_it_stands_alone(self, files):
        """It has nothing to fetch, links only to such files, and every reference to an id resolves, to one element."""
        assert not {"link", "img", "iframe", "object", "base"} & set(self.tags)
        assert not self.values("src")
        assert "@import" not in self.html
        assert not re.search(r"url\((?!#)", self.html)
        hrefs, ids = self.values("href") + self.values("xlink:href"), self.values("id")
        for href in hrefs:
            assert href.startswith(("#", *files))
        referred = [href[1:] for href in hrefs if href.startswith("#")]
        referred += self.values("aria-labelledby") + re.findall(r"url\(#([^)]+)\)", self.html)
        assert len(referred) > 10
        assert set(referred) <= set(ids)
        assert len(ids) == len(set(ids))


@pytest.fixture(scope="session")
def read():
    """Return a function that reads a page, given as HTML or as its path."""
    return lambda page: Document(page if isinstance(page, str) else page.read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def document(read, page):
    """The page, read."""
    return read(page)


# Studies to report on, written straight into their folder.


def finished(fun, rng):
    """Return the row of a trial that found a value."""
    wall = 0.1 + 0.01 * rng.random()
    trace = Trace(np.array([1, 10, 50]), np.array([fun + 9, fun + 1, fun]))
    return {
        "status": "ok", "fun": fun, "nfev": 100, "wall_s": wall, "cpu_s": wall, "objective_s": wall / 2,
        "stop": "budget", "outside_box": 0, "x": {"x1": rng.random()}, "metrics": {}, "trace": trace,
    }  # fmt: skip


FAILED = {"status": "failed", "error": "ValueError: <b>boom</b> & more\nTraceback …"}
RAISED = {"status": "failed", "error": "ProblemError: ValueError: no convergence\nTraceback …"}


@pytest.fixture(scope="session")
def make():
    """Return a function that writes a study whose optimizers differ by 1 a place.

    ``skip``, ``fail`` and ``raised`` hold cells (problem, optimizer) or trials (problem, optimizer, number), of which
    the problem loses those that are ``raised``; ``changes`` holds what is otherwise in the rows of an optimizer's
    finished trials, by optimizer; ``options`` its options, likewise.
    """

    def write_study(
        folder,
        problems=("p", "q"),
        optimizers=("a", "b", "c"),
        trials=8,
        *,
        skip=(),
        fail=(),
        raised=(),
        changes=None,
        options=None,
    ):
        def place_of(trial):
            return trial.number, problems.index(trial.problem), optimizers.index(trial.optimizer)

        own = options or {}
        entries = (
            tuple(Entry("any", label, own.get(label, {})) for label in labels) for labels in (problems, optimizers)
        )
        study = Study("made", *entries, trials=trials, budget=100)
        rng = np.random.default_rng(0)
        place = Folder(folder)
        place.path.mkdir(parents=True, exist_ok=True)
        place.claim(study)
        with place.store.writer() as writer:
            for trial in sorted(study.plan(), key=place_of):
                matches = {(trial.problem, trial.optimizer), trial.key}
                value = 5 + optimizers.index(trial.optimizer) + 0.1 * rng.standard_normal()
                if matches & {*fail, *raised}:
                    writer.add(trial, packed(RAISED if matches & set(raised) else FAILED))
                elif not matches & set(skip):
                    writer.add(trial, packed(finished(value, rng) | (changes or {}).get(trial.optimizer, {})))
        return folder

    return write_study
