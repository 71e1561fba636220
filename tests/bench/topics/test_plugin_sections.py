"""The sections of strangers' packages: after the harness's own, and whatever they do costs their own part alone."""

import pytest

from bench.topics import write_report
from tests.bench.topics.test_write import PARTS, numbered

CODE = """
import matplotlib.figure
import pandas as pd

from bench.report import Figure, Section, Table

FRAME = pd.DataFrame({"x": [1]})


def mine(findings):
    return Section("Mine", (findings.study.name,))


def cost(findings):
    return Section("Cost", ("Mine is cheap.",), (Table("mine", "A table.", FRAME),))


def units(findings):
    return [Section("In your units", ("One.",)), Section("In your units", ("Two.",))]


def part(findings):
    plot = matplotlib.figure.Figure()
    plot.subplots().plot([1, 2], [1, 2], "o")
    return [Section("Part", items=(Figure("part", "A figure.", plot, FRAME), Table("part", "A table.", FRAME)))]


def boom(findings):
    return 1 / 0


def number(findings):
    return 3


def half(findings):
    yield Section("Good", items=(Table("good", "Mine.", FRAME),))
    raise ValueError("later")


def undrawn(findings):
    wrong = matplotlib.figure.Figure()
    wrong.suptitle("$\\\\frac{$")  # is no mathematics
    return [Section("Bad", items=(Figure("wrong", "Wrong.", wrong, FRAME),))]
"""


def every(*names):
    return "strange_sections", "bench.report_sections", dict(zip(names, names, strict=True)), CODE


def test_they_come_after_the_harness_own_and_one_of_its_titles_adds_to_it(make, read, tmp_path, install):
    install(*every("mine", "cost", "units", "part"))
    folder = make(tmp_path / "s", problems=("p",), trials=2)
    page = read(write_report(folder))
    assert page.texts("h2") == numbered([*PARTS[:4], "In your units", *PARTS[4:], "Mine", "Part"])
    assert all(text in page.text for text in ("Mine made", "Mine is cheap.", "One.", "Two."))
    assert (folder / "tables" / "mine.csv").exists()
    beside = ("tables/", "figures/", "methods.", "references.", "answer.json", "CONTENTS.md", "glossary.", "warnings.")
    page.check_that_it_stands_alone(beside)


@pytest.mark.usefixtures("draws")
def test_one_that_fails_or_cannot_be_drawn_costs_only_itself(make, read, tmp_path, install):
    install(*every("mine", "boom", "number", "half", "undrawn"))
    folder = make(tmp_path / "s", problems=("p",), trials=2)
    page = read(write_report(folder))
    failed = [f"Section {name}" for name in ("boom", "half", "number", "undrawn")]
    assert page.texts("h2") == numbered([*PARTS, *failed[:2], "Mine", *failed[2:]])
    for name in ("boom", "number", "half", "undrawn"):
        assert f"The report section '{name}' failed and is left out" in page.text
    assert "ValueError: later" in page.text
    assert not (folder / "tables" / "good.csv").exists()
    assert (folder / "figures" / "every-run.svg").exists()
    assert not list((folder / "figures").glob("wrong*"))
