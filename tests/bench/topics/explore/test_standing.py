"""One table of cases for the ranks of a problem, which the report and the script of its interactive part reproduce."""

import json
from pathlib import Path

import pandas as pd
import pytest

from bench.analysis import pairwise_tests, standings, summarise
from bench.topics.explore.explore import final_places

CASES = json.loads(Path(__file__).with_name("standing.json").read_text(encoding="utf-8"))


def frame_of(case):
    rows = [
        ("p", optimizer, trial, "failed" if value is None else "ok", value)
        for optimizer, values in case["values"].items()
        for trial, value in enumerate(values)
    ]
    return pd.DataFrame(rows, columns=["problem", "optimizer", "trial", "status", "fun"])


def check(found, case):
    """Compare rank, beaten and chance by optimizer; the chance in ninths, which most cases have."""
    for optimizer in case["values"]:
        rank, beaten, chance = found[optimizer]
        ninths = case["ninths"][optimizer]
        assert (rank, beaten) == (case["rank"][optimizer], case["beaten"][optimizer])
        assert chance is None or pd.isna(chance) if ninths is None else chance == pytest.approx(ninths / 9)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_the_report(case):
    frame = frame_of(case)
    table = standings(summarise(frame), pairwise_tests(frame)).set_index("optimizer")
    check({name: tuple(table.loc[name, ["rank", "beaten", "chance"]]) for name in table.index}, case)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_the_script(case, call):
    frame = frame_of(case)
    places = pd.Series(final_places(frame))
    found = call("standing", [places[frame["optimizer"] == name].tolist() for name in case["values"]])
    each = zip(case["values"], found, strict=True)
    check({name: (own["rank"], own["beaten"], own["chance"]) for name, own in each}, case)


def test_names_of_cases_are_different():
    assert len({case["name"] for case in CASES}) == len(CASES)
