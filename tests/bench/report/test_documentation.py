"""The links of a page to the documentation: each is to a place that the documentation has."""

import ast
import re
from pathlib import Path

import pytest

import bench
from bench.analysis.finished_trials import CHECKS
from bench.analysis.integrity import TRAITS
from bench.helpers.text import slug
from bench.report import documentation
from bench.report.documentation import TERMS, Documentation
from bench.report.page import render
from bench.report.parts import Line, Section, warning

ROOT = Path(bench.__file__).parents[1]
SITE = "https://docs.example"


def places(page):
    """Return the anchors of a page of the reference: its titles, and the targets that it names."""
    text = (ROOT / "docs" / "reference" / f"{page}.md").read_text(encoding="utf-8")
    titles = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {slug(title) for title in titles} | set(re.findall(r"^\(([\w-]+)\)=$", text, re.MULTILINE))


def labels():
    """Return the labels of the lines that the sections of a page warn by: texts in their code, and checks by name."""
    found = {"completeness", "failures", "storage", "repeatability", *TRAITS, *CHECKS}
    for file in (ROOT / "bench").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "warning":
                found |= {node.args[0].value} if isinstance(node.args[0], ast.Constant) else set()
    return found


def test_every_warning_has_its_entry():
    assert len(labels()) > 30
    assert {slug(label) for label in labels()} <= places("warnings")


def test_every_term_has_its_entry():
    assert set(TERMS.values()) <= places("glossary")


def test_a_line_links_to_its_section_or_to_the_documentation(monkeypatch, view):
    monkeypatch.setattr("bench.report.page.site", lambda: SITE)
    lines = (warning("below the optimum", "One."), Line("where", "On p.", "Curves"), Line("passed", "All."))
    page = render("t", "", [view("one", Section("Trust", lines=lines)), view("two", Section("Curves"))])
    assert f'<dt><a href="{SITE}/reference/warnings.html#below-the-optimum">below the optimum</a></dt>' in page
    assert '<dt><a href="#two">where</a></dt>' in page
    assert "<dt>passed</dt>" in page


def test_a_term_is_linked_where_the_page_has_it_first():
    terms = Documentation(SITE).terms
    assert terms("A12 <of> B") == f'<a href="{SITE}/reference/glossary.html#a12">A12</a> &lt;of&gt; B'
    assert terms("A12, and budgets") == "A12, and budgets"
    assert Documentation("").terms("A12 & ERT") == "A12 &amp; ERT"


@pytest.mark.parametrize(
    ("declared", "found"), [(["Documentation, https://d.example/"], "https://d.example"), (None, "")]
)
def test_the_address_is_the_one_that_the_package_declares(monkeypatch, declared, found):
    monkeypatch.setattr(documentation, "metadata", lambda _: type("Metadata", (), {"get_all": lambda *_: declared})())
    assert documentation.site() == found
