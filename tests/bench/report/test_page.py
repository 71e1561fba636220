"""The page: what it says, that it is sound HTML, and that no text of a study can be more than text."""

import base64
import hashlib
import re
import zlib
from xml.etree import ElementTree

import matplotlib.figure
import numpy as np
import pandas as pd
import pytest

from bench.plots import style
from bench.report.page import FileRow, file_rows, grid, inline, render
from bench.report.parts import MOST_ROWS, Card, Figure, Line, Section, Table
from bench.report.write import save_figure

HOSTILE = "<script>alert(1)</script>&amp; {{ 7*7 }} {% raw %} \"'><b onclick=x>"


def table(frame, **options):
    return Table("t", "A caption.", frame, **options)


class TestPage:
    def test_it_stands_alone(self, document):
        document.check_that_it_stands_alone(("tables/", "figures/", "report.html"))

    def test_only_its_own_script_may_run(self, page, document):
        (script,) = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        (policy,) = [value for value in document.values("content") if "default-src" in value]
        assert "default-src 'none'" in policy
        assert f"script-src 'sha256-{digest}'" in policy
        assert len(script) < 7000
        assert not [name for _, attrs, _ in document.elements for name in attrs if name.startswith("on")]

    def test_headings_are_numbered_and_in_the_contents(self, document):
        assert document.texts("h2") == [
            "1 Verdict", "2 Comparison", "3 Curves", "4 Datasets", "5 Methods", "6 Files"
        ]  # fmt: skip
        assert document.texts("h3") == [
            "4.1 dataset 1",
            "4.2 dataset 2",
            "4.3 dataset 3",
        ]
        (contents,) = document.texts("nav")
        assert contents.startswith("Contents 1 Verdict 2 Comparison")
        assert "4 Datasets 3 sections 4.1 dataset 1" in contents

    def test_parts_are_numbered_through_and_files_named(self, document):
        assert document.texts("caption") == [
            "Table 1. Medians.", "Table 2. Everything.", "Data of Figure 1.",
            "Data of Figure 2.", "Paths are relative to this page. CSV files have all digits.",
        ]  # fmt: skip
        assert document.texts("figcaption") == ["Figure 1. A figure of few numbers.", "Figure 2. A figure of many."]
        folded = re.compile(r"Download|Data|\w+ \(\d+\)")
        assert [each for each in document.texts("summary") if folded.match(each)] == [
            "Download Table 1", "Download Table 2", "Data table and files of Figure 1",
            "Data table and files of Figure 2", "Files (3)",
        ]  # fmt: skip
        assert document.texts("a", href="tables/matrix.tex") == ["LaTeX"]
        assert "Table 1 as LaTeX" in document.values("aria-label")

    def test_cards_and_lines(self, document):
        (claim,) = document.texts("div", **{"class": "card claim"})
        (limit,) = document.texts("div", **{"class": "card limit"})
        assert "✓ cma-es is ranked first on 18 of 18 problems." in claim
        assert "✕ No optimizer" in limit
        assert document.texts("dt") == ["where", "ties", "odd"]
        assert document.texts("dd") == ["On easy ones.", "Few values.", "One."]

    def test_downloads_stand_together_by_kind(self, document):
        assert "figures/a%20b%23.pdf" in document.values("href")
        assert {"figures/a b#.pdf .svg", "report.html"} <= set(document.texts("th", scope="row"))
        assert {"A figure.", "this page"} <= set(document.texts("td"))

    def test_hostile_text_is_only_text(self, read, view):
        frame = pd.DataFrame({HOSTILE: [HOSTILE]}, index=pd.Index([HOSTILE], name=HOSTILE))
        part = Table("t", HOSTILE, frame, marks=pd.DataFrame({HOSTILE: [HOSTILE]}, index=frame.index), note=HOSTILE)
        figure = Figure("f", HOSTILE, None, frame)
        section = Section(
            HOSTILE, (HOSTILE,), (part, figure), (Card(HOSTILE, "limit"),), (Line(HOSTILE, HOSTILE, HOSTILE),),
            (Section(HOSTILE),), lost=HOSTILE, lists_files=True,
        )  # fmt: skip
        document = read(render(HOSTILE, HOSTILE, [view("v", section, [FileRow(f"a/{HOSTILE}", ["csv"], HOSTILE)])]))
        assert len(document.texts("script")) == 1
        assert "onclick" not in {name for _, attrs, _ in document.elements for name in attrs}
        shown = " ".join(HOSTILE.split())
        assert document.texts("td") == [shown * 2, shown, shown]
        assert document.texts("title") == document.texts("h1") == [shown]


class TestTable:
    def test_cells_are_set_as_asked(self, page, document):
        assert document.texts("th", scope="row")[:2] == ["p", "q"]
        assert document.texts("th", scope="col")[:3] == ["problem", "a", "b"]
        assert "<td><b>1</b></td>" in page
        assert "<td><i>4.500</i><sup>ab</sup></td>" in page

    def test_failures_are_red_and_have_a_sign(self, view):
        frame = pd.DataFrame({"failed": [3, 0]})
        lost = Section("s", items=(Table("t", "c", frame, lost=frame > 0),), lost="3 of 9 trials did not finish.")
        page = render("t", "", [view("v", lost)])
        assert '<p class="lost">3 of 9 trials did not finish.</p>' in page
        assert page.count('<td><span class="lost">3</span></td>') == 1
        assert "<td>0</td>" in page
        assert page.count("--lost: #") == 2
        assert '.lost::before { content: "✗ "; content: "✗ " / "failed: "; }' in page

    def test_a_long_table_is_cut_and_says_so(self, page, document):
        assert "The first 400 of 1,234 rows are shown; the other 834 are in figures/long.csv." in document.texts(
            "p", **{"class": "note"}
        )
        assert page.count("<tr>") == 1 + 2 + 1 + 12 + 1 + 2 + 1 + MOST_ROWS + 1 + 3  # the files

    def test_a_cut_table_keeps_its_marks(self):
        frame = pd.DataFrame({"a": np.arange(MOST_ROWS + 1)})
        cut = grid(table(frame, bold=frame < 1, italic=frame > 1, marks=frame.astype(str)))
        assert (len(cut.rows), cut.total) == (MOST_ROWS, MOST_ROWS + 1)
        assert [(row[0].bold, row[0].italic, row[0].mark) for row in cut.rows[:3]] == [
            (True, False, "0"), (False, False, "1"), (False, True, "2")
        ]  # fmt: skip

    @pytest.mark.parametrize("frame", [pd.DataFrame(), pd.DataFrame({"a": []}), pd.DataFrame(index=[1, 2])])
    def test_an_empty_table_is_a_table(self, read, frame, view):
        read(render("", "", [view("v", Section("S", items=(table(frame),)))]))

    def test_shades_are_classes_of_cells(self, view):
        frame = pd.DataFrame({"x": ["1", "3"], "y": ["2", ""]}, index=pd.Index(["p", "q"], name="problem"))
        shades = pd.DataFrame({"x": [0.0, 1.0], "y": [0.5, np.nan]}, index=frame.index)
        page = render("", "", [view("v", Section("S", items=(table(frame, shades=shades),)))])
        for cell in ('<td class="h0">1</td>', '<td class="h4">2</td>', '<td class="h7">3</td>', "<td></td>"):
            assert cell in page


class TestFolded:
    @pytest.fixture
    def folded(self, view):
        parts = (Section("one", ("About one.",), folded=True), Section("two", ("About two.",)))
        return [view("first", Section("First")), view("top", Section("All", sections=parts, folded=True))]

    def test_a_folded_subsection_shows_its_title_and_opens(self, read, folded):
        document = read(render("t", "", folded))
        assert document.texts("details", **{"class": "folded"}) == ["2.1 one About one."]
        assert document.texts("summary") == ["Contents", "2 sections", "2.1 one", "2.2 two"]
        assert "Open a section below to see it; only open ones are printed." in document.text

    def test_its_anchor_is_inside_so_that_a_link_opens_it(self, folded):
        page = render("t", "", folded)
        assert page.index("<summary><h3") < page.index('<section id="top-1">') < page.index("About one.")
        assert '<section id="top" class="part"' in page
        assert '<section id="first" class="opening"' in page


def test_a_file_in_several_formats_has_one_row():
    files = {"figures/a.svg": "A", "figures/a.pdf": "A", "figures/b.csv": "B", "x.html": "page"}
    assert file_rows(files) == [
        ("figures/a", ["pdf", "svg"], "A"),
        ("figures/b", ["csv"], "B"),
        ("x", ["html"], "page"),
    ]
    assert file_rows({}) == []


OWN = f"f{zlib.crc32(b'n'):x}"  # of the ids in a figure named n


class TestInline:
    @pytest.fixture
    def drawn(self, tmp_path):
        with style.context():
            figure = matplotlib.figure.Figure(figsize=(3.5, 2))
            axes = figure.subplots()
            axes.plot([1, 2, 3], [1.23456, 2, 1], "o-", label="a label")
            axes.fill_between([1, 3], [0, 1], [2, 3], hatch="///")
            axes.legend()
            return save_figure(Figure("drawn", "", figure, pd.DataFrame({"x": [1]})), tmp_path, "drawn")[0]

    def test_it_is_labelled_sized_and_without_what_does_not_show(self, drawn):
        svg = inline(drawn, "name", 'A "caption" & <more>')
        root = ElementTree.fromstring(svg)
        wanted = {"viewBox": "0 0 252 144", "style": "--width:487px", "role": "img"}
        assert root.attrib == wanted | {"aria-label": 'A "caption" & <more>'}
        assert not {"metadata", "style"} & {each.tag for each in root.iter()}

    def test_references_resolve_and_are_the_figures_own(self, drawn):
        svgs = [inline(drawn, name, "") for name in ("one", "two")]
        ids = [set(re.findall(r' id="([^"]+)"', svg)) for svg in svgs]
        assert all(ids)
        assert not ids[0] & ids[1]
        for svg, own in zip(svgs, ids, strict=True):
            assert set(re.findall(r'(?:href="|url\()#([^")]+)', svg)) <= own

    def test_by_hand(self):
        svg = (
            '<?xml version="1.0"?>\n<svg xmlns="http://www.w3.org/2000/svg" width="72pt" viewBox="0 0 72 72">'
            '<metadata>by</metadata><defs><style type="text/css">*{}</style></defs><path id="m" d="M 0 -3.00049"/>'
            '<use xlink:href="#m" x="1.239" style="fill: #ffffff; stroke: #123456"/><g clip-path="url(#m)"/>'
            '<text x="1.2"> #000000 id="m" 1.2345</text></svg>'
        )
        assert inline(svg, "n", "c") == (
            '<svg viewBox="0 0 72 72" style="--width:139px" role="img" aria-label="c">'
            '<defs></defs><path id="{n}.m" d="M 0 -3.00"/>'
            '<use href="#{n}.m" x="1.23" style="fill: var(--page); stroke: #123456"/><g clip-path="url(#{n}.m)"/>'
            '<text x="1.2"> #000000 id="m" 1.2345</text></svg>'.replace("{n}", OWN)
        )
