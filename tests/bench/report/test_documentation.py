"""The links of a page to the documentation: each is to a place that the documentation has."""

import ast
import re
from pathlib import Path

import bench
from bench.analysis.finished_trials import CHECKS
from bench.analysis.integrity import TRAITS
from bench.helpers.text import slug
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


def test_a_line_links_to_its_section_or_to_the_documentation(view):
    lines = (Line("where", "On p.", "Curves"), Line("passed", "All."))
    page = render("t", "", [view("one", Section("Trust", lines=lines)), view("two", Section("Curves"))])
    assert '<dt><a href="#two">where</a></dt>' in page
    assert "<dt>passed</dt>" in page
    place = warning("below the optimum", "One.").part
    assert Documentation(SITE).address(place) == f"{SITE}/reference/warnings.html#below-the-optimum"
