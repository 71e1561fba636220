"""What a notebook shows of results, studies and checks: small tables, in which every text is escaped."""

import re

import pytest

import bench
from bench.check.verdict import Checkup, Verdict
from bench.study import Entry, Study

HOSTILE = "<script>alert(1)</script> & \"'"
MANY = tuple(Entry(f"p{number}", f"p{number}") for number in range(1_200))


def result(_):
    sphere = bench.FunctionProblem(lambda x: (x**2).sum(axis=1), [-5.0] * 12, [5.0] * 12)
    return bench.solve(sphere, "random-search", budget=40, seed=7)


def study(_):
    return Study("mine", MANY, (Entry("gwo", HOSTILE),), trials=3, budget="1e4 * d", title=HOSTILE)


def results(folder):
    optimizers = (Entry("faulty", "faulty"), Entry("scatter", HOSTILE))
    bench.run(
        Study("failing", (Entry("sphere-2", "p"), Entry("sphere-3", "q")), optimizers, trials=2, budget=30),
        folder / "out",
        n_jobs=1,
    )
    return bench.Results(folder / "out")


def checkup(_):
    return Checkup(HOSTILE, (Verdict("box", "conformance", False, HOSTILE, "clip them"),))


@pytest.mark.parametrize(
    ("thing", "texts"),
    [
        (result, ["Result of one run", "best value", " and 2 more", "40 (stopped by: budget)"]),
        (study, ["Study mine", HOSTILE, "p9 and 1,190 more", "10,000 d evaluations"]),
        (results, [f"{HOSTILE} is first", "Results of study failing: 2 problems, 30 evaluations", "faulty"]),
        (checkup, [f"{HOSTILE} fails the contract in: box", "FAILED", f"{HOSTILE}; remedy: clip them"]),
    ],
)
def test_a_table_has_its_texts_escaped_and_no_colours(thing, texts, tmp_path, read):
    page = thing(tmp_path)._repr_html_()
    found = read(page)
    assert {*found.tags} <= {"table", "caption", "thead", "tbody", "tr", "th", "td"}
    assert all(text in found.text for text in texts)
    assert len(page) < 2_000
    assert not re.search(r"color|background", page)  # a notebook's theme, dark or light, has the colours
