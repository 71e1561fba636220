"""The figure that a reader changes: its curves are those of the picture, and it works under the page's policy."""

import numpy as np
import pytest
from markupsafe import Markup

from bench import Results, analysis
from bench.report.page import Item, View, render
from bench.report.parts import Section
from bench.topics.course import live
from bench.topics.course.curves import compared
from bench.topics.course.section import section
from bench.topics.findings import Findings

HOSTILE = "q</script><!--'\"&"
CURVES = "[...document.querySelectorAll('.live .mark-line path')].map((path) => path.getAttribute('d'))"


@pytest.fixture(scope="module")
def findings(make, tmp_path_factory):
    """Return the findings of 2 problems, 3 optimizers and 4 trials, of which one failed."""
    folder = tmp_path_factory.mktemp("live") / "s"
    return Findings(Results(make(folder, ("p", HOSTILE), ("a", "b", "<i>c"), trials=4, fail=[("p", "b", 1)])))


@pytest.fixture(scope="module")
def specification(findings):
    return live.targets_reached(findings)


def test_its_shares_are_those_of_the_picture(findings, specification):
    (columns,) = specification["data"]["values"]
    o, p, e, reached, of = (np.array(columns[name]) for name in ("o", "p", "e", "reached", "of"))
    grid = findings.of(compared).grid
    shares = analysis.ecdf(findings.anytime.hits(findings.trials.optimizers), grid).set_index(
        ["optimizer", "evaluations"]
    )["fraction"]
    for place, label in enumerate(findings.display.shown):
        for until in (0, 20, len(grid) - 1):
            own = [(o == place) & (p == problem) for problem in range(2)]
            share = np.mean([reached[cell & (e <= until)].sum() / of[cell].sum() for cell in own])
            assert share == pytest.approx(shares[label, grid[until]])


def test_it_works_in_a_page_and_its_picture_without_scripts(findings, browser, tmp_path):
    (figure,) = [item for item in section(findings).items if item.name == "targets-reached"]
    picture = Markup('<svg viewBox="0 0 9 9" role="img"></svg>')
    page = tmp_path / "report.html"
    view = View("part.1", Section("Curves", items=(figure,)), [Item("targets-reached", [], figure, picture)], [], [])
    page.write_text(render("A report", "", [view]), encoding="utf-8")
    browser.open(page)
    before = browser.wait(f"({CURVES}).length === 3 && {CURVES}")
    browser.page.locator(".live select").nth(0).select_option(label=HOSTILE)
    browser.wait(f"String({CURVES}) !== {str(','.join(before))!r}")
    browser.page.locator(".live .role-legend-symbol path").first.click(force=True)
    faint = "[...document.querySelectorAll('.live .mark-line path')].filter((path) => path.getAttribute('opacity') < 1)"
    browser.wait(f"{faint}.length === 2")
    assert browser.complaints == []
    assert set(browser.requests) == {page.as_uri()}
    browser.open(page, scripts=False)
    assert browser.page.locator(".plot svg").count() == 1
    assert browser.page.locator(".live svg").count() == 0
