"""The committed run of the thesis's comparison: it says what the documentation says, and its trials can be repeated."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from bench import Study, solve
from problems.backlash.report.fitting_errors import ORDER, SWARMS, ordered, published

FOLDER = Path(__file__).resolve().parents[3] / "results" / "thesis"


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


@pytest.fixture(scope="module")
def fits():
    table = pd.read_csv(FOLDER / "reference-fit.csv", index_col="problem")
    return table.rename(columns={"RMSE in the box": "box", "RMSE under the constraints": "constrained"})


@pytest.fixture(scope="module")
def excess(trials, fits):
    """How far each trial ends above the best fit under what it ran under, as a share of it."""
    under = np.where(trials["optimizer"] == "cma-es", "box", "constrained")
    return trials["fun"] / np.array([fits.at[cell] for cell in zip(trials["problem"], under, strict=True)]) - 1


def test_no_trial_beats_the_reference_fit_and_on_every_dataset_one_of_cma_es_finds_it(trials, excess):
    assert excess.min() > -1e-9  # the tolerance to which a fit is computed
    assert excess[trials["optimizer"] == "cma-es"].groupby(trials["problem"]).min().max() < 1e-9


@pytest.mark.slow
def test_its_reference_fits_are_those_of_today(fits):
    problem = Study.load("thesis").problem("signature-12")
    today = [problem.reference(constrained=constrained).value for constrained in (False, True)]
    assert today == pytest.approx(fits.loc["signature-12", ["box", "constrained"]].tolist(), rel=1e-9)


def test_its_regrets_and_the_shares_that_found_the_fit_follow_from_its_trials(trials, fits, excess):
    regret = pd.read_csv(FOLDER / "regret.csv").set_index(["problem", "optimizer"])["median"]
    medians = trials.groupby(["problem", "optimizer"])["fun"].median()
    under = ["box" if optimizer == "cma-es" else "constrained" for _, optimizer in medians.index]
    above = medians - [fits.at[cell] for cell in zip(medians.index.get_level_values("problem"), under, strict=True)]
    np.testing.assert_allclose(regret.reindex(above.index), above, rtol=0, atol=1e-9)
    found = pd.read_csv(FOLDER / "reference-fit-found.csv", index_col="problem").stack()
    share = 100 * (excess <= 0.01).groupby([trials["problem"], trials["optimizer"]]).mean()
    np.testing.assert_allclose(found.reindex(share.index), share)


@pytest.mark.slow
@pytest.mark.parametrize("level", [4, 17])
def test_the_code_of_today_repeats_its_means(means, level):
    """Fresh runs of today's code: the same law, so the same means within their own scatter."""
    study = Study.load("thesis")
    problem = study.problem(f"signature-{level:02}")
    for name, runs in (("gwo", 40), ("alo", 20), ("da", 20), ("goa", 12)):
        fresh = [
            solve(problem, study.optimizer(name), budget=study.budget.number, seed=10**9 + i).fun for i in range(runs)
        ]
        scatter = np.std(fresh, ddof=1) * np.sqrt(1 / runs + 1 / 30)
        assert abs(np.mean(fresh) - means.loc[level, name]) < 4 * scatter, name
