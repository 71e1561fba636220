"""The whole report, from a study's folder to the page."""

from html.parser import HTMLParser
from types import SimpleNamespace

import numpy as np
import pytest

from bench import BenchError, Trace
from bench.folder import Folder
from bench.report import Section, write, write_report
from bench.study import Entry, Study

VOID = {"meta", "br", "hr", "img", "link", "input"}


class Page(HTMLParser):
    """Collects a page's tags, attributes and text, and checks that tags are closed in order."""

    def __init__(self, path):
        super().__init__()
        self.tags, self.attributes, self.open, self.words, self.headings = [], [], [], [], []
        self.feed(path.read_text(encoding="utf-8"))
        self.close()
        self.text = " ".join(" ".join(self.words).split())

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += [(tag, *pair) for pair in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += [(tag, *pair) for pair in attrs]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] in ("style", "script"):
            return
        self.words.append(data)
        if "h2" in self.open and not data.strip().isdigit():
            self.headings.append(data.strip())

    def values(self, name):
        return [value for _, attribute, value in self.attributes if attribute == name]


def row(fun, rng, **figures):
    wall = 0.1 + 0.01 * rng.random()
    trace = Trace(np.array([1, 10, 50]), np.array([fun + 9, fun + 1, fun]))
    return {
        "status": "ok", "fun": fun, "nfev": 100, "wall_s": wall, "cpu_s": wall, "objective_s": wall / 2,
        "stop": "budget", "outside_box": 0, "x": {"x1": rng.random()}, "figures": figures, "trace": trace,
    }  # fmt: skip


FAILED = {"status": "failed", "error": "ValueError: <b>boom</b> & more\nTraceback …"}


def make(folder, problems=("p", "q"), optimizers=("a", "b", "c"), trials=8, skip=(), fail=()):
    """Write a study whose optimizers differ by 1 a place; skip and fail hold (problem, optimizer) or with a trial."""
    entries = (tuple(Entry("any", label) for label in labels) for labels in (problems, optimizers))
    study = Study("made", *entries, trials=trials, budget=100)
    rng = np.random.default_rng(0)
    place = Folder(folder)
    place.claim(study)
    with place.store.writer() as writer:
        for trial in study.plan():
            matches = {(trial.problem, trial.optimizer), trial.key}
            value = 5 + optimizers.index(trial.optimizer) + 0.1 * rng.standard_normal()
            if not matches & set(skip):
                writer.add(trial, FAILED if matches & set(fail) else row(value, rng))
    return folder


@pytest.fixture(autouse=True)
def _no_plugin_sections(monkeypatch):
    monkeypatch.setattr(write, "plugins", SimpleNamespace(entries=lambda group: {}, load=None))


def test_a_clear_winner_is_named_with_its_grounds(tmp_path):
    page = Page(write_report(make(tmp_path / "s")))
    assert "a is ranked first on 2 of 2 problems and separable from every rival on 2 of 2 (n = 8 trials" in page.text
    assert "No single winner" not in page.text
    assert not page.open


def test_the_eleven_parts_stand_in_their_order(tmp_path):
    page = Page(write_report(make(tmp_path / "s")))
    titles = [
        "Verdict", "Integrity checks", "Comparison", "Across problems", "Convergence and targets",
        "Problem by problem", "Time", "Power", "Methods", "Environment, seeds and data", "Downloads",
    ]  # fmt: skip
    assert page.headings == titles


@pytest.mark.parametrize("shape", [{"trials": 1}, {"optimizers": ("a",)}, {"skip": [("p", "a"), ("q", "b")]}])
def test_a_partial_study_has_all_parts_too(tmp_path, shape):
    assert len(Page(write_report(make(tmp_path / "s", **shape))).headings) == 11


def test_the_page_stands_alone(tmp_path):
    page = Page(write_report(make(tmp_path / "s")))
    assert not {"link", "img", "iframe", "object"} & set(page.tags)
    assert not page.values("src")
    for href in page.values("href") + page.values("xlink:href"):
        assert href.startswith(("#", "tables/", "figures/", "methods.", "references."))
    assert page.tags.count("svg") == page.tags.count("figure") == 8
    assert page.tags.count("caption") == page.tags.count("table")
    assert set(page.values("scope")) == {"col", "row"}
    ids = page.values("id")
    assert len(ids) == len(set(ids))
    assert {href[1:] for href in page.values("href") if href.startswith("#")} <= set(ids)


def test_every_file_named_on_the_page_exists_and_no_other(tmp_path):
    folder = make(tmp_path / "s")
    page = Page(write_report(folder))
    linked = {href for href in page.values("href") if not href.startswith("#")}
    assert {"methods.md", "methods.tex", "references.bib"} <= linked
    assert all((folder / href).is_file() for href in linked)
    linked = {href for href in linked if "/" in href}
    written = {str(path.relative_to(folder)) for kind in ("tables", "figures") for path in (folder / kind).iterdir()}
    assert linked == written
    assert {"tables/comparison.csv", "tables/comparison.tex", "figures/convergence.pdf", "tables/trials.csv"} <= written


def test_the_same_results_give_the_same_bytes(tmp_path):
    folder = make(tmp_path / "s", fail=[("p", "a", 0)])
    contents = []
    for _ in range(2):
        write_report(folder)
        files = [path for path in sorted(folder.rglob("*")) if path.is_file() and "sqlite" not in path.name]
        contents.append({path: path.read_bytes() for path in files})
    assert contents[0] == contents[1]


def test_no_single_winner_is_said(tmp_path):
    folder = make(tmp_path / "s", optimizers=("a", "b"), trials=3)
    page = Page(write_report(folder))
    assert "No single winner: a is ranked first on 2 of 2" in page.text
    assert "with 3 trials a cell the test can find no difference at all" in page.text
    assert page.text.count("1 of 1 pair cannot be significant whatever the values") == 2


def test_failed_and_missing_trials_are_said(tmp_path):
    folder = make(tmp_path / "s", fail=[("p", "b"), ("q", "a", 1)], skip=[("q", "c"), ("p", "a", 7)])
    page = Page(write_report(folder))
    assert "9 of 48 planned trials are missing and 1 of 6 cells are empty. Cells hold 0 to 8 trials" in page.text
    assert "fewer than others: a on p, c on q." in page.text
    assert "9 of 39 trials did not finish (failed 9), in b on p, a on q. They count as +inf." in page.text
    assert "No trial of c on this problem." in page.text
    assert "ValueError: <b>boom</b> & more" in page.text
    assert "Traceback" not in page.text


@pytest.mark.parametrize(
    "shape",
    [
        {"optimizers": ("a",)},
        {"optimizers": ("a",), "problems": ("p",), "trials": 1},
        {"trials": 1},
        {"problems": ("p",), "fail": [("p", "a"), ("p", "b"), ("p", "c")]},
        {"problems": ("p",), "skip": [("p", "a"), ("p", "b"), ("p", "c")]},
        {"skip": [("p", "a"), ("q", "b")]},
        {"skip": [("p", "a"), ("p", "b"), ("p", "c")]},
        {"optimizers": tuple(f"o{i}" for i in range(12)), "problems": ("p",)},
    ],
)
def test_every_partial_study_has_a_report(tmp_path, shape):
    page = Page(write_report(make(tmp_path / "s", **shape)))
    assert "Verdict" in page.text
    assert not page.open


def test_hostile_labels_are_only_text(tmp_path):
    problems = ("../../x", "<script>alert(1)</script>", "$\\frac{", 'a"b', "p:1/2")
    folder = make(tmp_path / "s", problems=problems, optimizers=("<img src=x onerror=y>", "a&b_%", "{{ 7*7 }}"))
    page = Page(write_report(folder))
    assert "img" not in page.tags
    assert page.tags.count("script") == 1  # the page's own
    assert "<script>alert(1)</script>: every pair of optimizers." in page.text
    assert "{{ 7*7 }}" in page.text
    assert {path.name for path in tmp_path.iterdir()} == {"s"}
    assert len(list((folder / "tables").glob("tests-*.csv"))) == len(problems)


def test_a_plugins_sections_come_after_the_comparison(tmp_path, monkeypatch):
    plug = SimpleNamespace(
        entries=lambda group: {"mine": None}, load=lambda group, name: lambda r: [Section("Mine", (r.study.name,))]
    )
    monkeypatch.setattr(write, "plugins", plug)
    page = Page(write_report(make(tmp_path / "s")))
    assert page.headings[2:5] == ["Comparison", "Mine", "Across problems"]


@pytest.mark.parametrize("result", [None, ["no section"], ZeroDivisionError("boom")])
def test_a_plugin_that_fails_costs_only_its_own_section(tmp_path, monkeypatch, result):
    def sections(results):
        if isinstance(result, Exception):
            raise result
        return result

    monkeypatch.setattr(write, "plugins", SimpleNamespace(entries=lambda g: {"bad": None}, load=lambda g, n: sections))
    page = Page(write_report(make(tmp_path / "s")))
    assert "The report section 'bad' failed and is left out" in page.text
    assert "Environment, seeds and data" in page.text


def test_a_folder_without_results_is_refused(tmp_path):
    with pytest.raises(BenchError):
        write_report(tmp_path)


def test_a_busy_machine_is_flagged(tmp_path):
    folder = make(tmp_path / "s", optimizers=("a", "b"), trials=4, skip=[("p", "a"), ("q", "a")])
    study, rng = Folder(folder).study(), np.random.default_rng(1)
    with Folder(folder).store.writer() as writer:
        for trial in study.plan():
            if trial.optimizer == "a":
                writer.add(trial, row(1.0, rng) | {"wall_s": 2.0, "cpu_s": 1.0, "nfev": 60, "stop": "undeclared"})
    page = Page(write_report(folder))
    assert "Trials of a waited for their core" in page.text
    assert "waited for their core" in page.text
    assert "Undeclared stops: 8 of 16 trials" in page.text
