"""The committed run of thesis --matched: it is of the shipped study, can be repeated, and pages print its numbers."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from bench import Study, solve
from bench.execution.job import Task
from bench.execution.supervisor import check
from bench.plugins.loading import load_problem
from bench.study.matched import with_controls

ROOT = Path(__file__).resolve().parents[3]
FOLDER = ROOT / "results" / "thesis-matched"


@pytest.fixture(scope="module")
def controls():
    return pd.read_csv(FOLDER / "controls.csv")


@pytest.fixture(scope="module")
def compared():
    return pd.read_csv(FOLDER / "same-conditions.csv")


def test_it_is_whole_and_of_the_shipped_study(controls):
    study = Study.load(FOLDER / "study.toml")
    thesis = Study.load("thesis")
    assert study == with_controls(thesis, check(Task.of(thesis)).descriptions)
    assert len(controls) == len(study.problems) * len(study.controls) * study.trials == 2700
    assert (controls["status"] == "ok").all()
    assert controls["seed"].is_unique


def test_the_chances_are_those_of_the_trials(controls, compared):
    own = pd.concat([pd.read_csv(ROOT / "results" / "thesis" / "trials.csv"), controls])
    runs = own.groupby(["problem", "optimizer"])["fun"].apply(np.array).unstack()
    assert len(compared) == 3 * 4
    for row in compared.itertuples():
        pairs = [np.meshgrid(*each) for each in zip(runs[row.first], runs[row.second], strict=True)]
        ties = [np.isclose(*pair, rtol=1e-10, atol=0) for pair in pairs]
        wins = [np.where(tie, 0.5, one < other) for tie, (one, other) in zip(ties, pairs, strict=True)]
        assert row.probability == pytest.approx(np.mean(wins))


@pytest.mark.parametrize("page", ["results/thesis-matched/README.md", "docs/explanation/fair-comparison.md"])
def test_the_pages_print_the_table(compared, page):
    text = (ROOT / page).read_text(encoding="utf-8")
    rows = re.findall(r"^\| (GWO|ALO|DA|GOA) ((?:\| \.\d\d \[\.\d\d, \.\d\d\] )+)\|$", text, re.MULTILINE)
    assert len(rows) == 4
    for name, cells in rows:
        own = compared[compared["rival"] == name.lower()][["probability", "low", "high"]].to_numpy().ravel()
        assert [float(each) for each in re.findall(r"\.\d\d", cells)] == pytest.approx(own, abs=0.00501)


def test_a_row_is_repeated_by_its_seed_and_options(controls):
    study = Study.load(FOLDER / "study.toml")
    row = controls[(controls["problem"] == "signature-08") & (controls["optimizer"] == "gwo (box)")].iloc[3]
    problem = load_problem("signature-08", unit="rpm")
    found = solve(problem, study.optimizer("gwo (box)"), budget=60_000, seed=int(row["seed"]))
    assert found.fun == row["fun"]
