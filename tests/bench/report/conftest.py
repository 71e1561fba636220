"""A page with one of everything, its reader, and studies to report on."""

import numpy as np
import pandas as pd
import pytest

from bench.report.page import FileRow, Item, View, inline, render
from bench.report.parts import Card, Figure, Line, Section, Table, Typography

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
    """A verdict, tables to sort and to filter, figures with short and long data, datasets and files."""
    cards = (
        Card("cma-es is ranked first on 18 of 18 problems.", "claim"),
        Card("No optimizer is shown to be equal to another.", "limit"),
    )
    lines = (
        Line("where", "On easy ones.", "Curves"),
        Line("ties", "Few values.", "warnings#ties"),
        Line("odd", "One."),
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
        "matrix",
        "Medians.",
        pair,
        Typography(bold=pair < 2, italic=pair > 4, marks=marks),
        note="Letters: not separable.",
    )
    short = Figure("short", "A figure of few numbers.", None, pd.DataFrame({"x": [1, 2], "y": [3.0, 4.0]}))
    long = Figure("long", "A figure of many.", None, pd.DataFrame({"x": np.arange(1234), "y": np.arange(1234) / 7}))
    datasets = tuple(Section(f"dataset {i}", (f"About dataset {i}.",)) for i in range(1, 4))
    return [
        view("section-1", Section("Verdict", ("A sentence.",), cards=cards, lines=lines)),
        view("section-2", Section("Comparison", items=(matrix, Table("wide", "Everything.", wide)))),
        view("section-3", Section("Curves", items=(short, long))),
        view("section-4", Section("Datasets", sections=datasets)),
        view("section-5", Section("Methods", ("A paragraph.",))),
        view(
            "section-6",
            Section("Files", lists_files=True),
            [
                FileRow("figures/a b#", ["pdf", "svg"], "A figure."),
                FileRow("report", ["html"], "this page"),
                FileRow("tables/trials", ["csv"], "every trial"),
            ],
        ),
    ]


@pytest.fixture(scope="session")
def page(views):
    """The page of these views."""
    return render("A <report>", "Five optimizers & more.", views)


@pytest.fixture(scope="session")
def document(read, page):
    """The page, read."""
    return read(page)
