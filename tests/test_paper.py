"""The paper: its length, its references, and its numbers, which come from committed results."""

import csv
import re
from pathlib import Path

import pandas as pd
import pytest

from bench.analysis import compare

ROOT = Path(__file__).resolve().parents[1]
HEAD, TEXT = (ROOT / "paper" / "paper.md").read_text(encoding="utf-8").split("---\n", 2)[1:]
SENTENCES = " ".join(TEXT.split())


def rows(name):
    with (ROOT / "results" / name).open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_it_is_as_long_as_reviewers_ask_for():
    assert 750 <= len(TEXT.split()) <= 1750


def test_every_reference_is_cited_and_known():
    works = re.findall(r"^@\w+\{(\w+),", (ROOT / "paper" / "paper.bib").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(set(re.findall(r"@(\w+)", TEXT))) == sorted(works)


def test_its_shares_of_runs_that_found_the_best_fit_are_those_of_the_results():
    found = {row["optimizer"]: float(row["found %"]) for row in rows("thesis/reference-fit-by-optimizer.csv")}
    assert f"{found['cma-es']:.0f}% of its runs, GWO in {found['gwo']:.0f}%" in SENTENCES
    assert found["alo"] == found["da"] == found["goa"] == 0
    names = {f"minion:{name}" for name in ("NLSHADE_RSP", "LSHADE", "ARRDE", "jSO")}
    plus = rows("thesis-plus/reference-fit-by-optimizer.csv")
    heirs = [float(row["found %"]) for row in plus if row["optimizer"] in names]
    assert f"in {min(heirs):.0f}% to {max(heirs):.0f}% of 36 runs each" in SENTENCES


def in_the_thesis():
    table = compare(pd.read_csv(ROOT / "results" / "thesis" / "trials.csv"), "cma-es", before=False)
    return table.rename(columns={"chance": "probability"}).set_index("rival").loc["gwo"]


def under_equal_conditions():
    table = pd.read_csv(ROOT / "results" / "thesis-equal" / "same-conditions.csv")
    return table[table["conditions"] == "agents = 300"].set_index("second").loc["gwo 300"]


@pytest.mark.parametrize("pair", [in_the_thesis, under_equal_conditions])
def test_its_chances_are_those_of_the_results(pair):
    chance, low, high = (f"{float(pair()[name]):.2f}".lstrip("0") for name in ("probability", "low", "high"))
    assert re.search(
        rf"{re.escape(chance)}, with an? (95% )?interval of {re.escape(low)} to {re.escape(high)}", SENTENCES
    )


def test_its_ranks_are_those_of_the_results():
    first, second = rows("thesis/ranking.csv")[:2]
    assert (first["optimizer"], second["optimizer"]) == ("cma-es", "gwo")
    assert first["first"] == first["problems"] == "18"
    assert "ranks first on all 18 recordings" in SENTENCES
