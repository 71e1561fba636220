"""Power of the Kolmogorov-Smirnov test, against scipy and known figures."""

import numpy as np
import pytest
from scipy.stats import ks_2samp

from bench.analysis.power import critical_distance, detectable_shift, power_table

pytestmark = pytest.mark.filterwarnings("error")


def test_thirty_trials():
    assert critical_distance(30, 0.05) == 11
    assert critical_distance(30, 0.005) == 14
    assert detectable_shift(30, 0.05) == pytest.approx(0.89, abs=0.03)
    assert detectable_shift(30, 0.005) == pytest.approx(1.19, abs=0.03)


def test_the_detectable_shift_has_the_power_it_says():
    rng = np.random.default_rng(4)
    shift = detectable_shift(12, 0.05)
    seen = [ks_2samp(*pair, method="exact").pvalue <= 0.05 for pair in rng.normal([[0], [shift]], 1, (400, 2, 12))]
    assert np.mean(seen) == pytest.approx(0.8, abs=0.06)  # three standard errors


def test_three_trials_can_show_nothing():
    assert critical_distance(3, 0.05) is None
    assert detectable_shift(3, 0.05) is None


def test_table():
    table = power_table(30, pairs=10)
    assert table["level"].tolist() == ["alpha", "first Holm step"]
    assert table["alpha"].tolist() == [0.05, 0.005]
    assert table["distance"].tolist() == [11, 14]
    assert table["shift"].tolist() == [detectable_shift(30, 0.05), detectable_shift(30, 0.005)]


@pytest.mark.parametrize("n", [0, 1, 3])
def test_table_of_too_few_trials_has_no_figures(n):
    assert power_table(n, pairs=10)[["distance", "shift"]].isna().all(axis=None)


@pytest.mark.parametrize("pairs", [0, 1])
def test_table_of_a_single_pair_has_no_holm_step(pairs):
    assert power_table(30, pairs)["level"].tolist() == ["alpha"]
