"""Studies to report on, and a reader of pages."""

import re
from html.parser import HTMLParser

import numpy as np
import pytest

from bench import Trace
from bench.report.library import library
from bench.storage.folder import Folder
from bench.study import Entry, Study
from bench.trial.columns import packed

VOID = {"meta", "link", "input", "img", "br", "hr"}


class Document(HTMLParser):
    """A page's elements as (tag, attributes, text within), tags checked to be closed in order."""

    def __init__(self, html):
        super().__init__()
        self.html, self.elements, self.open, self.words = html, [], [], []
        self.feed(html)
        self.close()
        assert not self.open
        self.tags = [tag for tag, _, _ in self.elements]
        self.text = " ".join(" ".join(self.words).split())  # what a reader sees, and the title

    def handle_starttag(self, tag, attrs):
        self.handle_startendtag(tag, attrs)
        if tag not in VOID:
            self.open.append(self.elements[-1])

    def handle_startendtag(self, tag, attrs):
        assert len(dict(attrs)) == len(attrs)
        self.elements.append((tag, dict(attrs), []))

    def handle_endtag(self, tag):
        assert self.open.pop()[0] == tag

    def handle_data(self, data):
        for _, _, text in self.open:
            text.append(data)
        if self.open and self.open[-1][0] not in ("style", "script"):
            self.words.append(data)

    def texts(self, tag, **attributes):
        return [
            " ".join("".join(text).split())
            for name, attrs, text in self.elements
            if name == tag and attributes.items() <= attrs.items()
        ]

    def values(self, attribute):
        return [attrs[attribute] for _, attrs, _ in self.elements if attribute in attrs]

    def check_that_it_stands_alone(self, files):
        """It has nothing to fetch, links only to such files, and every reference to an id resolves, to one element."""
        assert not {"link", "img", "iframe", "object", "base"} & set(self.tags)
        assert not self.values("src")
        own = self.html.replace(library(), "")
        assert "@import" not in own
        assert not re.search(r"url\((?!#)", own)
        hrefs, ids = self.values("href") + self.values("xlink:href"), self.values("id")
        for href in hrefs:
            assert href.startswith(("#", *files))
        referred = [href[1:] for href in hrefs if href.startswith("#")]
        referred += self.values("aria-labelledby") + re.findall(r"url\(#([^)]+)\)", own)
        assert len(referred) > 10
        assert set(referred) <= set(ids)
        assert len(ids) == len(set(ids))


@pytest.fixture(scope="session")
def read():
    """Return a function that reads a page, given as HTML or as its path."""
    return lambda page: Document(page if isinstance(page, str) else page.read_text(encoding="utf-8"))


# Studies to report on, written straight into their folder.


def finished(fun, rng):
    """Return the row of a trial that found a value."""
    wall = 0.1 + 0.01 * rng.random()
    trace = Trace(np.array([1, 10, 50]), np.array([fun + 9, fun + 1, fun]))
    return {
        "status": "ok", "fun": fun, "nfev": 100, "wall_s": wall, "cpu_s": wall, "objective_s": wall / 2,
        "stop": "budget", "outside_box": 0, "x": {"x1": rng.random()}, "metrics": {}, "trace": trace,
    }  # fmt: skip


def ended(fun, **changes):
    """Return the row of a trial that found a value at once."""
    return {
        "status": "ok", "fun": fun, "nfev": 10, "wall_s": 1.0, "cpu_s": 1.0, "objective_s": 0.5, "stop": "budget",
        "outside_box": 0, "x": {}, "metrics": {}, "trace": Trace(np.array([1]), np.array([fun])),
    } | changes  # fmt: skip


FAILED = {"status": "failed", "error": "ValueError: <b>boom</b> & more\nTraceback …"}
RAISED = {"status": "failed", "error": "ProblemError: ValueError: no convergence\nTraceback …"}


def store(folder, study, row_of, trials=None, record=None):
    """Write a study whose trials have the rows that a function returns, None for a trial that is missing.

    ``record`` is that of the run that made them.
    """
    place = Folder(folder)
    place.path.mkdir(parents=True, exist_ok=True)
    place.claim(study)
    with place.store.writer() as writer:
        run = writer.record("environments", record) if record else None
        for trial in trials or study.plan():
            if row := row_of(trial):
                writer.add(trial, packed(row), run)
    return folder


@pytest.fixture(scope="session")
def make():
    """Return a function that writes a study whose optimizers differ by 1 a place.

    ``skip``, ``fail`` and ``raised`` hold cells (problem, optimizer) or trials (problem, optimizer, number), of which
    the problem loses those that are ``raised``; ``changes`` holds what is otherwise in the rows of an optimizer's
    finished trials, by optimizer; ``options`` its options, likewise; ``record`` is that of the run; ``more`` holds
    further fields of the study.
    """

    def write_study(
        folder,
        problems=("p", "q"),
        optimizers=("a", "b", "c"),
        trials=8,
        *,
        skip=(),
        fail=(),
        raised=(),
        changes=None,
        options=None,
        record=None,
        **more,
    ):
        def place_of(trial):
            return trial.number, problems.index(trial.problem), optimizers.index(trial.optimizer)

        own = options or {}
        entries = (
            tuple(Entry("any", label, own.get(label, {})) for label in labels) for labels in (problems, optimizers)
        )
        study = Study("made", *entries, trials=trials, **{"budget": 100} | more)
        rng = np.random.default_rng(0)

        def row_of(trial):
            matches = {(trial.problem, trial.optimizer), trial.key}
            value = 5 + optimizers.index(trial.optimizer) + 0.1 * rng.standard_normal()
            if matches & {*fail, *raised}:
                return RAISED if matches & set(raised) else FAILED
            if matches & set(skip):
                return None
            return finished(value, rng) | (changes or {}).get(trial.optimizer, {})

        store(folder, study, row_of, sorted(study.plan(), key=place_of), record)
        return folder

    return write_study
