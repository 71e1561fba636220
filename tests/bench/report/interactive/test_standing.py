"""One table of cases for the ranks of a problem, which the report and the script of its interactive part reproduce."""

import json
import shutil
import subprocess
from importlib import resources
from pathlib import Path

import pandas as pd
import pytest

from bench.analysis import pairwise_tests, standings, summarise
from bench.report.interactive.explore import final_places

CASES = json.loads(Path(__file__).with_name("standing.json").read_text(encoding="utf-8"))
SCRIPT = resources.files("bench.report.interactive").joinpath("script/standing.js")


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


@pytest.fixture(scope="module")
def answers():
    """What the script returns for every case, from the places that the page holds; one process for all."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("no node to run the script of the interactive part")
    samples = []
    for case in CASES:
        frame = frame_of(case)
        places = pd.Series(final_places(frame))
        samples.append([places[frame["optimizer"] == name].tolist() for name in case["values"]])
    code = f"{SCRIPT.read_text(encoding='utf-8')}\nconsole.log(JSON.stringify({json.dumps(samples)}.map(standing)));"
    done = subprocess.run([node, "-"], input=code, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


@pytest.mark.parametrize("place", range(len(CASES)), ids=[case["name"] for case in CASES])
def test_the_script(answers, place):
    case = CASES[place]
    each = zip(case["values"], answers[place], strict=True)
    check({name: (own["rank"], own["beaten"], own["chance"]) for name, own in each}, case)


def test_names_of_cases_are_different():
    assert len({case["name"] for case in CASES}) == len(CASES)
