"""The page: what it says, that it is sound HTML, and that no text of a study can be more than text."""

import base64
import hashlib
import re
import zlib

import matplotlib.figure
import pandas as pd
import pytest

from bench.plots import style
from bench.report.page import FileRow, inline, render
from bench.report.parts import Card, Figure, Line, Section, Table, Typography
from bench.report.write import save_figure

HOSTILE = "<script>alert(1)</script>&amp; {{ 7*7 }} {% raw %} \"'><b onclick=x>"


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

    def test_hostile_text_is_only_text(self, read, view):
        frame = pd.DataFrame({HOSTILE: [HOSTILE]}, index=pd.Index([HOSTILE], name=HOSTILE))
        part = Table(
            "t", HOSTILE, frame, Typography(marks=pd.DataFrame({HOSTILE: [HOSTILE]}, index=frame.index)), note=HOSTILE
        )
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
    def test_failures_are_red_and_have_a_sign(self, view):
        frame = pd.DataFrame({"failed": [3, 0]})
        lost = Section(
            "s", items=(Table("t", "c", frame, Typography(lost=frame > 0)),), lost="3 of 9 trials did not finish."
        )
        page = render("t", "", [view("v", lost)])
        assert '<p class="lost">3 of 9 trials did not finish.</p>' in page
        assert page.count('<td><span class="lost">3</span></td>') == 1
        assert "<td>0</td>" in page
        assert page.count("--lost: #") == 2
        assert '.lost::before { content: "✗ "; content: "✗ " / "failed: "; }' in page


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
