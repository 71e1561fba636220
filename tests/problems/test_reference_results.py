"""The committed run of the thesis's comparison: it says what the README says, and its trials can be repeated."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from bench import Study, solve
from problems.report.fitting_errors import ORDER, SWARMS, ordered, published

FOLDER = Path(__file__).resolve().parents[2] / "results" / "thesis"


@pytest.fixture(scope="module")
def trials():
    return pd.read_csv(FOLDER / "trials.csv")


@pytest.fixture(scope="module")
def means(trials):
    table = trials.pivot_table(index="problem", columns="optimizer", values="fun", aggfunc="mean")
    return table.rename(index=lambda name: int(name.removeprefix("signature-")))


def test_it_is_whole(trials):
    assert len(trials) == 18 * 5 * 30
    assert (trials["status"] == "ok").all()
    assert trials["seed"].is_unique
    swarms = trials[trials["optimizer"] != "cma-es"]
    assert (swarms["nfev"] == 60_000).all()
    assert (trials["nfev"] <= 60_000).all()
    assert (trials.loc[trials["nfev"] < 60_000, "stop"].str.startswith("tol")).all()


def test_it_reproduces_table_7_2(means):
    swarms = list(SWARMS)
    difference = (means[swarms] / published()[swarms] - 1).abs()
    assert difference.to_numpy().max() <= 0.35
    assert np.median(difference) <= 0.10
    assert ordered(means[list(ORDER)]) >= 15


def test_it_is_of_the_shipped_study():
    assert Study.load(FOLDER / "study.toml") == Study.load("thesis")


def test_the_code_of_today_repeats_its_means(means):
    """Fresh runs of today's code on three datasets: the same law, so the same means within their own scatter."""
    study = Study.load("thesis")
    for label, level in (("signature-04", 4), ("signature-09", 9), ("signature-17", 17)):
        problem = study.problem(label)
        for name, runs in (("gwo", 40), ("alo", 20), ("da", 20), ("goa", 12)):
            fresh = [
                solve(problem, study.optimizer(name), budget=study.budget, seed=10**9 + i).fun for i in range(runs)
            ]
            scatter = np.std(fresh, ddof=1) * np.sqrt(1 / runs + 1 / 30)
            assert abs(np.mean(fresh) - means.loc[level, name]) < 4 * scatter, (label, name)
