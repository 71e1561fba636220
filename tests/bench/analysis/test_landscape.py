"""Features against pflacco's on the same points, and what they must be on functions whose landscape is known.

The numbers are those of pflacco 1.2.2, in an environment of its own, on the points x and the values y of ``sample``:

    pip install pflacco==1.2.2
    calculate_ela_distribution(x, y); calculate_ela_meta(x, y); calculate_dispersion(x, y); calculate_nbc(x, y)
    calculate_information_content(x, y, ic_nn_start=0)
    calculate_fitness_distance_correlation(x, y, proportion_of_best=0.5)

pflacco's count of peaks adds heights to widths, so that it is not compared.
"""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.distance import cdist
from scipy.stats import qmc, spearmanr

from bench import BenchError, FunctionProblem
from bench.analysis import landscape

PFLACCO = {
    "rastrigin": {
        "ela_distr.skewness": 0.3014437765223439, "ela_distr.kurtosis": -0.09020338953303542,
        "ela_meta.lin_simple.adj_r2": 0.013824426928080502, "ela_meta.lin_simple.intercept": 0.49346955284502086,
        "ela_meta.lin_simple.coef.min": 0.01268914074792291, "ela_meta.lin_simple.coef.max_by_min": 7.797633278847675,
        "ela_meta.lin_w_interact.adj_r2": 0.006226576633117653, "ela_meta.quad_simple.adj_r2": 0.9197474104139098,
        "ela_meta.quad_simple.cond": 1.029382820403347, "ela_meta.quad_w_interact.adj_r2": 0.917025676277915,
        "disp.ratio_mean_02": 0.4472982733701287, "disp.ratio_median_25": 0.6265660033787768,
        "nbc.nn_nb.sd_ratio": 0.7256068791372644, "nbc.nn_nb.mean_ratio": 0.8283321589995685,
        "nbc.nn_nb.cor": 0.398442331599258, "nbc.dist_ratio.coeff_var": 0.23457199716637367,
        "nbc.nb_fitness.cor": -0.5147078380407868, "ic.h_max": 0.8416772409348281, "ic.eps_s": 0.38538538538538525,
        "ic.eps_max": 0.45161671174712514, "ic.eps_ratio": -0.2552552552552551, "ic.m0": 0.5743243243243243,
        "fdc": 0.5836777661469444,
    },
    "ridge": {
        "ela_distr.skewness": -0.251242943595063, "ela_meta.lin_simple.adj_r2": 0.9473054190165716,
        "ela_meta.quad_w_interact.adj_r2": 0.9997218596767035, "disp.ratio_mean_05": 0.5664445985191833,
        "disp.ratio_median_10": 0.5373611618682603, "nbc.nn_nb.cor": 0.557809832675215,
        "nbc.nb_fitness.cor": -0.3105541010952473, "ic.h_max": 0.7838945453688113, "ic.eps_ratio": -0.45545545545545535,
        "fdc": 0.6001941473886859,
    },
}  # fmt: skip
FUNCTIONS = {
    "rastrigin": lambda x: ((10 * x - 5.3) ** 2 - 3 * np.cos(2 * np.pi * (10 * x - 5.3))).sum(axis=1) + 5 * x[:, 0],
    "ridge": lambda x: np.abs(x[:, 0] - 0.3) + 10 * np.sqrt((x[:, 1:] ** 2).sum(axis=1)),
}


def sample(name):
    x = qmc.Halton(3, scramble=False).random(151)[1:]
    y = FUNCTIONS[name](x)
    return x, (y - y.min()) / np.ptp(y)


def problem(function, lower=(-5,) * 3, upper=(5,) * 3, **options):
    return FunctionProblem(function, lower, upper, **options)


def bowl(x):
    return (x**2).sum(axis=1)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_features_equal_those_of_pflacco(name):
    x, y = sample(name)
    distances = cdist(x, x)
    found = landscape.distribution(y) | landscape.meta_models(x, y) | landscape.dispersion(x, y)
    found |= landscape.nearest_better(distances, y) | landscape.information_content(distances, y, start=0)
    best = np.argsort(y)[:75]  # pflacco divides the covariance by n, and both deviations by n - 1
    found["fdc"] = landscape.fdc(distances[np.ix_(best, best)], y[best]) * 74 / 75
    assert {each: found[each] for each in PFLACCO[name]} == pytest.approx(PFLACCO[name], rel=1e-9)


def test_a_bowl_and_a_plane_are_what_they_are():
    shown = landscape.describe(problem(bowl))
    assert shown["ela_meta.quad_simple.adj_r2"] == pytest.approx(1)
    assert shown["ela_meta.quad_simple.cond"] == pytest.approx(1)
    assert shown["ela_meta.lin_simple.adj_r2"] < 0.1
    assert shown["fitness_distance.correlation"] > 0.9
    plane = landscape.describe(problem(lambda x: x @ np.array([1.0, 2.0, 4.0])))
    assert plane["ela_meta.lin_simple.adj_r2"] == pytest.approx(1)
    assert plane["ela_meta.lin_simple.coef.max_by_min"] == pytest.approx(4)
    noise = landscape.describe(problem(lambda x: np.random.default_rng(1).random(len(x))))
    assert noise["disp.ratio_mean_05"] > 0.8 > shown["disp.ratio_mean_05"]
    assert noise["ic.m0"] > shown["ic.m0"]


def test_peaks_of_the_values_are_counted():
    y = np.concatenate([np.random.default_rng(2).normal(place, 0.05, 200) for place in (0, 1, 2)])
    assert landscape.distribution(y)["ela_distr.number_of_peaks"] == 3
    assert landscape.distribution(y[:200])["ela_distr.number_of_peaks"] == 1


def test_units_change_nothing_and_the_seed_repeats():
    one = landscape.describe(problem(bowl), 100)
    other = landscape.describe(problem(lambda x: 7 + 1e9 * bowl(x / 10), (-50,) * 3, (50,) * 3), 100)
    assert other == pytest.approx(one, rel=1e-6)
    assert landscape.describe(problem(bowl), 100) == one
    assert landscape.describe(problem(bowl), 100, seed=1) != one


def test_odd_problems_are_described_as_far_as_they_can_be():
    assert landscape.describe(problem(bowl, (-1,), (1,)))["ela_meta.lin_simple.coef.max_by_min"] == 1
    half = landscape.describe(problem(lambda x: np.where(x[:, 0] > 0, np.inf, bowl(x))))
    assert np.isfinite(half["ic.h_max"])
    stairs = landscape.describe(problem(lambda x: np.where(x[:, 0] > 4.9, 1.0, 0.0)))
    assert stairs["disp.ratio_mean_25"] == pytest.approx(1, abs=0.1)
    huge = landscape.describe(problem(lambda x: 1e308 * (bowl(x) / 37.5 - 1)))
    assert np.isfinite(huge["fitness_distance.correlation"])
    whole = landscape.describe(problem(bowl, integer=[True] * 3))
    assert whole["ela_meta.quad_simple.adj_r2"] == pytest.approx(1)


@pytest.mark.parametrize(
    ("function", "points", "reason"),
    [
        (bowl, 29, "at least 30 points"),
        (lambda x: np.zeros(len(x)), None, "the same value at all 750 points"),
        (lambda x: np.full(len(x), np.inf), None, "a finite value at 0 of 750 points"),
    ],
)
def test_what_cannot_be_described_is_refused(function, points, reason):
    with pytest.raises(BenchError, match=reason):
        landscape.describe(problem(function), points)


def ranked(problems):
    """Return features and medians: a wins where the feature is small, c is always last."""
    names = [f"p{i}" for i in range(problems)]
    grow = np.arange(problems, dtype=float)
    noise = np.random.default_rng(3).random(problems)
    table = pd.DataFrame({"grow": grow, "noise": noise, "same": 1.0}, index=names)
    a = np.where(grow < problems / 2, 1.0, 3.0)
    return table, pd.DataFrame({"a": a, "b": 2.0, "c": 9.0}, index=names)


def test_a_feature_that_goes_with_the_winner_is_found():
    table, medians = ranked(20)
    found = landscape.feature_ranks(table, medians)
    first = found.iloc[:2].set_index("optimizer")
    assert set(first.index) == {"a", "b"}
    assert set(first["feature"]) == {"grow"}
    assert first.loc["a", "rho"] > 0.8
    assert first.loc["a", "rho"] == pytest.approx(spearmanr(table["grow"], medians.rank(axis=1)["a"])[0])
    assert list(found["significant"]) == [True, True, False, False]  # c has one rank, and "same" one value
    assert (found["p_adjusted"] >= found["p"]).all()


def test_problems_of_one_block_are_no_evidence_of_their_own():
    """Five functions in four dimensions: 120 orders of blocks, of which every fifth has the first one at its place."""
    table, medians = ranked(20)
    blocks = {label: f"f{place // 4}" for place, label in enumerate(table.index)}
    places = {label: place % 4 for place, label in enumerate(table.index)}
    alone, together = (landscape.feature_ranks(table, medians, *by).iloc[0] for by in ((), (blocks, places)))
    assert alone["rho"] == together["rho"]
    assert alone["p"] <= 0.002 < 0.01 < together["p"]
    assert (landscape.feature_ranks(table, medians, dict.fromkeys(blocks, "one"), places)["p"] == 1).all()


def test_a_feature_that_is_missing_somewhere_is_compared_elsewhere():
    table, medians = ranked(20)
    table.loc["p3", "grow"] = np.nan
    found = landscape.feature_ranks(table, medians)
    first = found[(found["optimizer"] == "a") & (found["feature"] == "grow")].iloc[0]
    known = table["grow"].notna()
    assert first["problems"] == 19
    assert first["rho"] == pytest.approx(spearmanr(table["grow"][known], medians.rank(axis=1)["a"][known])[0])


def test_few_problems_show_nothing():
    assert landscape.feature_ranks(*ranked(9)).empty
