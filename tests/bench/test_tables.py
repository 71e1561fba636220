"""What a notebook shows of results, studies and checks: small tables, in which every text is escaped."""

import re
from html.parser import HTMLParser

import bench
from bench.check.verdict import Checkup, Verdict
from bench.study import Entry, Study

HOSTILE = "<script>alert(1)</script> & \"'"


class Texts(HTMLParser):
    """Collects the texts of a page by row, and the tags that were opened and closed."""

    def __init__(self, page):
        super().__init__()
        self.rows, self.opened, self.closed = [], [], []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.opened.append(tag)
        if tag in ("tr", "caption"):
            self.rows.append([])

    def handle_endtag(self, tag):
        self.closed.append(tag)

    def handle_data(self, data):
        self.rows[-1].append(data)


def rows(thing):
    page = thing._repr_html_()
    found = Texts(page)
    assert sorted(found.opened) == sorted(found.closed)
    assert set(found.opened) <= {"table", "caption", "thead", "tbody", "tr", "th", "td"}
    assert not re.search(r"color|background", page)  # a notebook's theme, dark or light, has the colours
    return ["".join(found.rows[0])], *found.rows[1:]


def test_the_result_of_a_run():
    sphere = bench.FunctionProblem(lambda x: (x**2).sum(axis=1), [-5.0] * 12, [5.0] * 12)
    result = bench.solve(sphere, "random-search", budget=40, seed=7)
    title, *found = rows(result)
    told = dict(found)
    assert title == ["Result of one run"]
    assert told["best value"] == f"{result.fun:.10g}"
    assert told["best point"].endswith(" and 2 more")
    assert told["evaluations"] == "40 (stopped by: budget)"
    assert told["seed"] == "7"


def test_a_study():
    many = tuple(Entry(f"p{number}", f"p{number}") for number in range(1_200))
    study = Study("mine", many, (Entry("gwo", HOSTILE),), trials=3, budget="1e4 * d", title=HOSTILE)
    title, *found = rows(study)
    told = dict(found)
    assert title == ["Study mine"]
    assert told["title"] == told["optimizers (1)"] == HOSTILE
    assert told["problems (1,200)"].endswith("p9 and 1,190 more")
    assert told["budget of a trial"] == "10,000 d evaluations"
    assert len(study._repr_html_()) < 2_000


def test_the_results_of_a_folder_with_failures(small_study, tmp_path):
    optimizers = (Entry("faulty", "faulty"), Entry("scatter", HOSTILE))
    study = Study("failing", small_study.problems, optimizers, trials=2, budget=30)
    bench.run(study, tmp_path / "out", n_jobs=1)
    verdict, *_, title, heads, first, second = rows(bench.Results(tmp_path / "out"))
    assert verdict[0].startswith(f"No winner on these 2 problems: {HOSTILE} is first")
    assert title == ["Results of study failing: 2 problems, 30 evaluations"]
    assert heads == ["optimizer", "trials", "failed"]
    assert [first, second] == [["faulty", "2", "2"], [HOSTILE, "4", "0"]]


def test_a_checkup():
    verdicts = (
        Verdict("budget", "conformance", True, "kept"),
        Verdict("box", "conformance", False, HOSTILE, "clip them"),
    )
    title, heads, *found = rows(Checkup(HOSTILE, verdicts))
    assert title == [f"{HOSTILE} fails the contract in: box"]
    assert found == [["budget", "passed", "kept"], ["box", "FAILED", f"{HOSTILE}; remedy: clip them"]]
    assert heads == ["check", "outcome", "finding"]
