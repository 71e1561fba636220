"""Bands of runtime distributions: by hand where that is possible, and where nothing, or everything, was reached."""

import numpy as np
import pandas as pd
import pytest

from bench.analysis.anytime import ecdf
from bench.analysis.bands import UNSEEN, curve_bands, curve_of, leads, spells

GRID = np.geomspace(1, 100, 20)


def hits(**times):
    """Return the hits of optimizers on one problem, whose times are (runs, targets)."""
    rows = [
        ("p", optimizer, trial, evaluations)
        for optimizer, of_runs in times.items()
        for trial, of_run in enumerate(of_runs)
        for evaluations in of_run
    ]
    return pd.DataFrame(rows, columns=["problem", "optimizer", "trial", "evaluations"])


@pytest.fixture
def rng():
    return np.random.default_rng(1)


def test_the_curve_is_the_runtime_distribution(rng):
    table = hits(a=rng.uniform(1, 90, (6, 4)), b=rng.uniform(30, 200, (9, 4)))
    np.testing.assert_allclose(curve_bands(table, GRID)["fraction"], ecdf(table, GRID)["fraction"])


def test_the_variance_is_that_of_runs_within_problems_and_of_what_they_did_not_show(rng):
    cells = [rng.random((5, 1)), rng.random((8, 1))]
    expected = 0.0
    for cell in cells:
        values, weights = np.append(cell, [0.0, 1.0]), np.append(np.ones(len(cell)), [UNSEEN, UNSEEN])
        centre = np.average(values, weights=weights)
        spread = (weights * (values - centre) ** 2).sum() / (weights.sum() - 1)
        expected += (1 / 2) ** 2 * spread / len(cell)
    assert curve_of(cells, rng).variance[0] == pytest.approx(expected)


def test_a_single_run_has_no_band_and_shows_no_lead(rng):
    table = hits(a=[[2.0, 3.0]], b=rng.uniform(50, 99, (9, 2)))
    assert curve_bands(table, GRID).groupby("optimizer")["low"].count().to_dict() == {"a": 0, "b": 20}
    assert (leads(table, GRID)["ahead"] == "").all()


def test_curves_that_cross_have_a_spell_each(rng):
    slow_start = 20 + rng.uniform(0, 1, (30, 4))
    table = hits(fast=np.hstack([rng.uniform(1, 3, (30, 2)), np.full((30, 2), np.inf)]), thorough=slow_start)
    found = spells(leads(table, GRID))
    assert found["ahead"].tolist() == ["fast", "thorough"]
    assert found.loc[0, "end"] < 20 < found.loc[1, "begin"]
