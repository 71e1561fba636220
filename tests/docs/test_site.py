"""The built site: every page near, no dead link, nothing from elsewhere, searchable offline, accessible.

``nox -s docs`` builds the site and runs these tests on it; the folder is in $BENCH_SITE.
"""

import importlib.util
import json
import os
from collections import deque
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag, urlparse

import pytest

CLICKS = 3
LOADED = {("script", "src"), ("link", "href"), ("img", "src"), ("iframe", "src"), ("source", "src")}
VOID = {"area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "source", "track", "wbr"}

pytestmark = pytest.mark.skipif(
    "BENCH_SITE" not in os.environ, reason="no built site: 'nox -s docs' builds it and runs these tests on it"
)


class Page(HTMLParser):
    """The links of a page, those of its main part, its ids, and what a browser loads for it."""

    def __init__(self, path):
        super().__init__()
        self.links, self.main, self.ids, self.loaded, self.inside = [], [], set(), [], 0
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.ids |= {given[key] for key in ("id", "name") if given.get(key)}
        if tag == "main" or (self.inside and tag not in VOID):
            self.inside += 1
        if tag == "a" and given.get("href"):
            self.links.append(given["href"])
            if self.inside:
                self.main.append(given["href"])
        if given.get("rel") not in ("canonical", "search", "index", "next", "prev"):
            self.loaded += [given[key] for name, key in LOADED if name == tag and given.get(key)]

    def handle_endtag(self, tag):
        if self.inside and tag not in VOID:
            self.inside -= 1


@pytest.fixture(scope="module")
def site():
    """Return the built site's folder."""
    return Path(os.environ["BENCH_SITE"]).resolve()


@pytest.fixture(scope="module")
def pages(site):
    """Return the pages by path; those that the theme only has for scripts are left out."""
    found = {path: Page(path) for path in site.rglob("*.html") if "_" not in path.relative_to(site).parts[0][:1]}
    assert len(found) > 50
    return found


def target_of(path, link):
    """Return the file and the anchor that a link of a page leads to; None for other sites."""
    if urlparse(link).scheme:
        return None
    address, anchor = urldefrag(link)
    return (path.parent / unquote(address)).resolve() if address else path, unquote(anchor)


def test_every_page_is_within_three_clicks(site, pages):
    """But for the guides that lie beside a report, which are copies of pages of the site."""
    distance, queue = {site / "index.html": 0}, deque([site / "index.html"])
    while queue:
        path = queue.popleft()
        for link in pages[path].main:
            target = target_of(path, link)
            if target and target[0] in pages and target[0] not in distance:
                distance[target[0]] = distance[path] + 1
                queue.append(target[0])
    made_by_sphinx = {site / "search.html", site / "genindex.html", site / "py-modindex.html"}
    guides = {path for name in ("warnings", "glossary") for path in (site / "examples").rglob(f"{name}.html")}
    far = {path for path in pages if distance.get(path, CLICKS + 1) > CLICKS} - made_by_sphinx - guides
    assert sorted(str(path.relative_to(site)) for path in far) == []


def test_no_link_is_dead(site, pages):
    dead = []
    for path, page in pages.items():
        for link in page.links:
            target = target_of(path, link)
            if target is None or link == "#":
                continue
            file, anchor = target
            known = pages[file].ids if file in pages else None
            if not file.is_file() or (anchor and known is not None and anchor not in known):
                dead.append((str(path.relative_to(site)), link))
    assert dead == []


def test_the_gallery_has_its_reports_and_none_is_large(site, pages):
    """That of 24 functions in two dimensions has about 9 MB: its curves are drawn as matplotlib writes them."""
    links = {link for link in pages[site / "gallery.html"].main if link.startswith("examples/")}
    reports = {link.split("#")[0] for link in links}
    assert len(reports) >= 5
    assert all((site / report).stat().st_size < 12e6 for report in reports)


def test_nothing_is_loaded_from_elsewhere(site, pages):
    strange = {
        (str(path.relative_to(site)), each)
        for path, page in pages.items()
        for each in page.loaded
        if urlparse(each).scheme not in ("", "data") or each.startswith("//")
    }
    assert strange == set()


@pytest.fixture(scope="module")
def axe():
    """Return axe-core's source."""
    return Path(importlib.util.find_spec("axe_core_python").origin).with_name("axe.min.js").read_text(encoding="utf-8")


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", [1280, 400])
@pytest.mark.parametrize(
    "name",
    ["index", "tutorials/first-comparison", "how-to/index", "reference/study", "reference/commands/run",
     "reference/optimizers/gwo", "reference/python/run", "explanation/reading-a-difference"],
)  # fmt: skip
def test_axe_finds_nothing(browser, site, axe, name, width, dark):
    browser.open(site / f"{name}.html", width=width, dark=dark)
    browser.run("document.head.insertAdjacentHTML('beforeend', '<style>* { transition: none !important }</style>')")
    browser.run(axe)  # colours that are still changing have no contrast
    found = json.loads(browser.run("axe.run().then((done) => JSON.stringify(done))"))
    assert len(found["passes"]) > 15
    assert [(each["id"], each["impact"], each["nodes"][0]["html"]) for each in found["violations"]] == []


@pytest.mark.parametrize("width", [1280, 400, 320])
def test_no_page_scrolls_sideways(browser, site, pages, width):
    wide = []
    for path in pages:
        browser.open(path, width=width)
        if not browser.run("document.documentElement.scrollWidth <= document.documentElement.clientWidth"):
            wide.append(str(path.relative_to(site)))
    assert wide == []


def test_the_search_works_from_a_file(browser, site):
    browser.open(site / "search.html", state="?q=backlash")
    assert browser.wait("document.querySelectorAll('#search-results ul.search li').length > 5")
