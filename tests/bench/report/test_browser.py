"""The page in a browser: accessible, sortable, filterable and printable, by keyboard, without scripts and offline."""

import importlib.util
import json
import os
from pathlib import Path

import pytest

from bench.report.page import render
from bench.report.parts import Section

OPEN_ALL = "for (const each of document.querySelectorAll('details')) each.open = true"


@pytest.fixture(scope="module")
def file(page, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "report.html"
    path.write_text(page, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def axe():
    """Return axe-core's source: the file that AXE_CORE names, or the one of the package axe-core-python."""
    spec = importlib.util.find_spec("axe_core_python")
    path = os.environ.get("AXE_CORE") or (spec and Path(spec.origin).with_name("axe.min.js"))
    if not path:
        pytest.skip("no axe-core: install axe-core-python, or set AXE_CORE to an axe.min.js")
    return Path(path).read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", [1280, 400])
def test_axe_finds_nothing(browser, file, axe, width, dark):
    browser.open(file, width=width, dark=dark)
    browser.run(OPEN_ALL)
    browser.run(axe)
    found = json.loads(browser.run("axe.run().then((done) => JSON.stringify(done))"))
    assert len(found["passes"]) > 15
    assert [(each["id"], each["impact"], each["nodes"][0]["html"]) for each in found["violations"]] == []


@pytest.mark.sampled(1)
@pytest.mark.parametrize("width", [320, 400, 768, 1280])
def test_the_page_never_scrolls_sideways(browser, file, width):
    browser.open(file, width=width)
    browser.run(OPEN_ALL)
    assert browser.run("document.documentElement.scrollWidth <= document.documentElement.clientWidth")


class TestSorting:
    @pytest.fixture
    def column(self, browser, file):
        """Return a function that sorts the wide table by a column, and returns the values and the state."""
        browser.open(file)

        def sort(name, click=True):
            return browser.run(
                f"""(() => {{
                    const table = document.querySelector('#wide table');
                    const heads = [...table.tHead.rows[0].cells];
                    const at = heads.findIndex((head) => head.textContent === {json.dumps(name)});
                    if ({json.dumps(click)}) heads[at].querySelector('button').click();
                    const states = heads.map((head) => head.ariaSort).filter((state) => state);
                    return [[...table.tBodies[0].rows].map((row) => row.cells[at].textContent), states];
                }})()"""
            )

        return sort

    def test_numbers_sort_by_value_and_missing_ones_last(self, column):
        original = column("value", click=False)
        assert original[1] == []
        rising = ["-2", "1e-05", "0.5", "3", "7", "8", "9", "99", "1200", "1234", "∞", "–"]
        assert column("value") == [rising, ["ascending"]]
        assert column("value") == [[*rising[-2::-1], "–"], ["descending"]]
        assert column("value") == original


class TestFilter:
    INPUT = "document.querySelector('#wide input')"
    SHOWN = "[...document.querySelectorAll('#wide tbody tr')].filter((row) => row.offsetHeight).length"
    STATUS = "document.querySelector('#wide [role=status]').textContent"

    @pytest.mark.slow
    def test_rows_are_filtered_and_counted(self, browser, file):
        browser.open(file)
        browser.run(OPEN_ALL)
        assert browser.run(self.STATUS) == ""
        browser.run(f"{self.INPUT}.focus()")
        browser.page.keyboard.insert_text("PROBLEM-1")
        assert (browser.run(self.SHOWN), browser.run(self.STATUS)) == (4, "4 of 12 rows")
        browser.page.keyboard.insert_text("x")
        assert (browser.run(self.SHOWN), browser.run(self.STATUS)) == (0, "0 of 12 rows")
        browser.run(f"{self.INPUT}.select()")
        browser.page.keyboard.insert_text(" ")
        assert (browser.run(self.SHOWN), browser.run(self.STATUS)) == (12, "")


class TestKeyboard:
    @pytest.mark.slow
    def test_everything_is_reached_by_tab_and_the_titles_of_a_table_by_one(self, browser, file):
        browser.open(file)
        browser.run(OPEN_ALL)
        stops = "a, .all, input, summary, th:first-child > button"
        wanted = browser.run(f"document.querySelectorAll('{stops}').length")
        scrolled = "[...document.querySelectorAll('.scroll')].filter((each) => each.scrollWidth > each.clientWidth)"
        wanted += browser.wait(f"{scrolled}.every((each) => each.tabIndex === 0) && {scrolled}.length + 1") - 1
        browser.run("window.reached = new Set(); addEventListener('focusin', (event) => reached.add(event.target))")
        for _ in range(wanted + 1):
            browser.press("Tab")
        assert browser.run("reached.size") == wanted


def test_without_scripts_all_is_shown_and_nothing_is_dead(browser, file):
    browser.open(file, scripts=False)
    assert browser.run("document.querySelectorAll('button, input').length") == 0
    browser.run(OPEN_ALL)
    assert browser.run("[...document.querySelectorAll('#wide tbody tr')].every((row) => row.offsetHeight > 0)")
    assert browser.run("document.querySelectorAll('#wide tbody tr').length") == 12


class TestOffline:
    def test_only_the_page_is_asked_for_and_nothing_is_complained_of(self, browser, file):
        browser.open(file)
        browser.run(OPEN_ALL)
        assert browser.requests == [file.as_uri()]
        assert browser.complaints == []

    def test_the_policy_lets_nothing_out_or_in(self, browser, file):
        browser.open(file)
        refused = """new Promise((done) => {
            const seen = [];
            addEventListener("securitypolicyviolation", (event) => {
                seen.push(event.effectiveDirective);
                if (seen.length === 3) done(seen.sort());
            });
            const add = (tag, more) => document.body.append(Object.assign(document.createElement(tag), more));
            add("img", { src: "http://127.0.0.1:9/x.png" });
            add("script", { textContent: "window.ran = true" });
            fetch("http://127.0.0.1:9/").catch(() => {});
        })"""
        assert browser.run(refused) == ["connect-src", "img-src", "script-src-elem"]
        assert browser.run("window.ran") is None
        assert len(browser.complaints) >= 3  # the console reports each, so that its silence elsewhere means something


class TestFolded:
    SEEN = "document.querySelector('#top-1 p').checkVisibility({ contentVisibilityAuto: true })"

    @pytest.fixture
    def folded(self, view, tmp_path):
        parts = tuple(Section(name, (f"About {name}.",), folded=True) for name in ("one", "two"))
        path = tmp_path / "report.html"
        views = [view("first", Section("First")), view("top", Section("All", sections=parts))]
        path.write_text(render("t", "", views), encoding="utf-8")
        return path

    @pytest.mark.sampled(1)
    @pytest.mark.parametrize("scripts", [True, False])
    def test_a_link_opens_the_section(self, browser, folded, scripts):
        browser.open(folded, scripts=scripts)
        assert not browser.run(self.SEEN)
        browser.run("document.querySelector('nav a[href=\"#top-1\"]').click()")
        assert browser.wait(self.SEEN)
        assert browser.run("document.querySelectorAll('main details[open]').length") == 1
