"""The interactive part in a browser: its state in the address, clicks, keys, and no complaint."""

import importlib.util
import json
import os
from itertools import product
from pathlib import Path
from urllib.parse import quote

import pandas as pd
import pytest

from bench.report.page import Item, View, render
from bench.report.parts import Section, Table
from bench.topics.explore.explore import look_further

READY = (
    "[...document.querySelectorAll('.chart')].every((chart) => chart.dataset.ready) && document.querySelector('.chart')"
)
ABOUT = "document.querySelector('.about').textContent"


@pytest.fixture(scope="module")
def file(findings, tmp_path_factory):
    path = tmp_path_factory.mktemp("further") / "report.html"
    ranks = pd.DataFrame({"a": [1], "b": [2]}, index=pd.Index(["p"], name="problem"))
    ranking = Table("rank-map", "Ranks.", ranks, cells={("p", "a"): ("p", "a"), ("p", "b"): ("p", "b")})
    views = [
        View("part.1", Section("Verdict", items=(ranking,)), [Item("rank-map", [], ranking)], [], []),
        View("part.2", Section("More", ("A sentence.",)), [], [], []),
    ]
    path.write_text(render("A report", "", views, further=look_further(findings)), encoding="utf-8")
    return path


@pytest.fixture
def look(browser, file):
    """Return a function that opens the page with a state in its address, and waits until the charts are drawn."""

    def opened(state="", **options):
        browser.open(file, state=f"#look-further?{state}", **options)
        browser.wait(READY)
        return browser

    yield opened
    assert browser.complaints == []
    assert {address.split("#")[0] for address in browser.requests} == {file.as_uri()}


def middle(browser, selector):
    box = f"document.querySelector({json.dumps(selector)}).getBoundingClientRect()"
    return browser.run(f"((box) => [box.x + box.width / 2, box.y + box.height / 2])({box})")


def click(browser, selector):
    browser.page.mouse.click(*middle(browser, selector))


def state(browser):
    return browser.run("decodeURIComponent(location.hash)")


class TestState:
    def test_the_address_chooses_the_view(self, look):
        assert "targets of 2 problems" in look().run(ABOUT)
        assert look("problem=p").run(ABOUT).startswith("p: medians")
        assert look("view=values&problem=p").run(ABOUT).startswith("p: every point is a run")
        assert look("view=ranks").run(ABOUT).startswith("Ranks")

    @pytest.mark.slow
    def test_optimizers_problems_and_budget_come_from_the_address(self, look, hostile):
        browser = look(f"view=ranks&optimizer=a&optimizer=b&without={quote(hostile)}&budget=10")
        browser.run("document.querySelector('.further-body > details').open = true")
        shown = browser.run("document.querySelector('.further-body > details table').innerText").split()
        assert " ".join(shown) == "ranks after 10 evaluations problem a b p 1 2 mean rank 1 2"
        assert "2 of 3 optimizers, 1 of 2 problems" in browser.run(
            "document.querySelector('[role=status]').textContent"
        )

    @pytest.mark.slow
    def test_a_choice_goes_into_the_address_and_back(self, look):
        browser = look("problem=p")
        browser.run("document.querySelector('input[value=values]').click()")
        browser.run("[...document.querySelectorAll('.boxes input')][1].click()")
        assert state(browser) == "#look-further?view=values&problem=p&optimizer=a&optimizer=<i>c"
        browser.run("location.hash = '#look-further?view=ranks'")
        assert browser.wait(f"{ABOUT}.startsWith('Ranks')")

    @pytest.mark.sampled(1)
    @pytest.mark.parametrize(
        "nonsense", ["view=constructor&problem=none&budget=-1&zoom=1,x&run=9,a&target=7&only=a=b", "%"]
    )
    def test_nonsense_in_the_address_shows_the_usual_view(self, look, nonsense):
        assert "targets of 2 problems" in look(nonsense).run(ABOUT)

    @pytest.mark.slow
    def test_little_or_nothing_chosen_is_no_error(self, look, hostile):
        browser = look()
        nothing = f"without=p&without={quote(hostile)}"
        for view, chosen in product(("curves", "values", "ranks"), ("optimizer=", "optimizer=a", nothing)):
            shown = f"#look-further?view={view}&{chosen}"
            browser.run(f"document.querySelector('.chart').dataset.ready = '', location.hash = {json.dumps(shown)}")
            browser.wait(READY)
            assert "cannot be drawn" not in browser.run("document.querySelector('.further').innerText")

    def test_a_hostile_label_is_text_and_a_state(self, look, hostile):
        browser = look(f"view=values&problem={quote(hostile)}")
        assert browser.run(ABOUT).startswith(hostile + ":")
        assert browser.run("document.querySelectorAll('.further i').length") == 0


class TestClicks:
    def test_a_cell_leads_to_its_problem_and_a_point_to_its_run(self, look):
        browser = look("view=ranks")
        click(browser, ".chart .mark-rect path")
        browser.wait(f"{ABOUT}.startsWith('p: every point') && {READY} && document.querySelector('.mark-symbol')")
        assert state(browser) == "#look-further?view=values&problem=p&cell=a"
        click(browser, ".chart .mark-symbol.role-mark path")
        browser.wait("document.querySelector('.run h3')")
        words = browser.run("document.querySelector('.run').innerText")
        assert "Run of a on p" in words
        seed = browser.run("JSON.parse(document.getElementById('look-further.data').textContent).cells[0].seed[0]")
        assert f"bench solve any any --budget 100 --seed {seed}" in words
        assert "stopped by\nbudget" in words
        assert "&run=0,a" in state(browser)

    @pytest.mark.slow
    def test_a_cell_of_the_pages_own_map_leads_to_its_problem(self, look):
        browser = look()
        browser.run("document.querySelector('[data-problem=p][data-optimizer=b]').click()")
        assert state(browser) == "#look-further?view=values&problem=p&cell=b"

    @pytest.mark.slow
    def test_a_run_is_drawn_with_its_trace_and_the_fit_to_the_data(self, look):
        browser = look("view=values&problem=p&run=2,a")
        assert browser.run("document.querySelectorAll('.chart.trace svg, .chart.fit svg').length") == 2
        assert "height (m)" in browser.run("document.querySelector('.chart.fit').textContent")

    @pytest.mark.slow
    def test_a_failed_run_is_shown_with_its_error(self, look):
        browser = look("view=values&problem=p&run=1,b")
        assert "failed: ValueError: <b>boom</b> & more" in browser.run("document.querySelector('.run').innerText")
        assert "b (1 without a value)" in browser.run("document.querySelector('.chart').textContent")

    @pytest.mark.slow
    def test_values_are_shown_under_the_pointer(self, look):
        browser = look("problem=p")
        box = "document.querySelector('.chart svg').getBoundingClientRect()"
        x, y = browser.run(f"[{box}.x + {box}.width * .6, {box}.y + {box}.height / 2]")
        for shift in (0, 3):
            browser.page.mouse.move(x + shift, y)
        shown = browser.wait("document.querySelector('#vg-tooltip-element.visible')?.innerText")
        assert "evaluations" in shown
        assert "<i>c" in shown

    @pytest.mark.slow
    def test_a_drawn_rectangle_zooms(self, look):
        browser = look("problem=p")
        box = "document.querySelector('.chart svg').getBoundingClientRect()"
        x, y = browser.run(f"[{box}.x + 200, {box}.y + 100]")
        browser.page.mouse.move(x, y)
        browser.page.mouse.down()
        browser.page.mouse.move(x + 200, y + 100)
        browser.page.mouse.up()
        assert "&zoom=" in state(browser)


class TestKeyboard:
    @pytest.mark.slow
    def test_keys_zoom_move_and_show_the_whole(self, look):
        browser = look("problem=p&x=linear")
        browser.run("document.querySelector('.chart').focus()")
        browser.press("+")
        assert "zoom=25.75,75.25," in state(browser)
        browser.press("ArrowRight")
        assert "zoom=38.125,87.625," in state(browser)
        browser.press("0")
        assert "zoom" not in state(browser)

    @pytest.mark.slow
    def test_a_run_is_chosen_from_a_list(self, look):
        browser = look("view=values&problem=p")
        browser.run("document.querySelector('.further-body > label select').focus()")
        browser.press("ArrowDown")
        assert browser.wait("document.querySelector('.run h3')?.textContent") == "Run of a on p"


@pytest.mark.slow
@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", [1280, 400])
def test_axe_finds_nothing_and_nothing_is_wider_than_the_page(look, width, dark):
    spec = importlib.util.find_spec("axe_core_python")
    path = os.environ.get("AXE_CORE") or (spec and Path(spec.origin).with_name("axe.min.js"))
    if not path:
        pytest.skip("no axe-core: install axe-core-python, or set AXE_CORE to an axe.min.js")
    for view in ("view=values&problem=p&run=2,a", "view=ranks", ""):
        browser = look(view, width=width, dark=dark)
        browser.run("for (const each of document.querySelectorAll('details')) each.open = true")
        browser.run(Path(path).read_text(encoding="utf-8"))
        found = json.loads(browser.run("axe.run().then((done) => JSON.stringify(done))"))
        assert [(each["id"], each["impact"], each["nodes"][0]["html"]) for each in found["violations"]] == []
        assert browser.run("document.documentElement.scrollWidth <= document.documentElement.clientWidth")


@pytest.mark.slow
def test_without_scripts_and_on_paper_nothing_is_dead(browser, file):
    browser.open(file, scripts=False)
    assert "This part needs scripts" in browser.run("document.querySelector('#look-further').innerText")
    assert browser.run("document.querySelectorAll('#look-further :is(button, input, select)').length") == 0
    browser.open(file, media="print")
    assert browser.run("document.querySelector('#look-further').offsetHeight") == 0
