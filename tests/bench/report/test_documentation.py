"""The links of a page to the documentation: each is to a place that the documentation has."""

import ast
import re
from pathlib import Path

import bench
from bench.analysis.finished_trials import CHECKS
from bench.analysis.integrity import TRAITS
from bench.helpers.text import slug
from bench.report.documentation import GUIDES, TERMS
from bench.report.page import render, render_guide
from bench.report.parts import Line, Section, warning

ROOT = Path(bench.__file__).parents[1]


def places(name):
    """Return the ids of a guide."""
    return set(re.findall(r'id="([^"]+)"', render_guide(name)))


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


def test_a_guide_links_to_places_that_are_beside_the_report():
    for name in GUIDES:
        assert "nav > details" in render_guide(name)  # the style of the report, as it is
        for page, place in re.findall(r'href="([^"#]*)#?([^"]*)"', render_guide(name)):
            assert page in ("", "report.html", *(f"{other}.html" for other in GUIDES))
            assert not place or place in places(page.removesuffix(".html") or name)


def test_a_line_links_to_its_section_or_to_the_guide_beside_the_page(view):
    lines = (Line("where", "On p.", "Curves"), warning("below the optimum", "One."), Line("passed", "All."))
    views = [view("one", Section("Trust", lines=lines)), view("two", Section("Curves"))]
    page = render("t", "", views, guides=True)
    assert '<dt><a href="#two">where</a></dt>' in page
    assert '<dt><a href="warnings.html#below-the-optimum">below the optimum</a></dt>' in page
    assert "<dt>passed</dt>" in page
    assert "warnings.html" not in render("t", "", views)
