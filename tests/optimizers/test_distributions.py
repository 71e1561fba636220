"""Whole distributions of final bests, of every algorithm and variant, are those of the plain reference.

The reference's sample is drawn once, by ``python tests/optimizers/sample.py``; its seeds are none of those used here.
"""

import csv
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import ks_2samp

from optimizers.alo import ALO, walk_ants
from optimizers.da import DA
from optimizers.goa import GOA
from optimizers.gwo import GWO, promote
from tests.optimizers.functions import AGENTS, BOXES, FUNCTIONS, GENERATIONS, VARIANTS, D, final_bests
from tests.optimizers.reference import final_best

pytestmark = pytest.mark.slow

CLASSES = {"gwo": GWO, "alo": ALO, "goa": GOA, "da": DA}
RUNS = 200
LEVEL = 0.01  # of all comparisons together


@pytest.fixture(scope="module")
def reference():
    """The reference's runs, by function, algorithm and variant: pairs of a seed and a final best."""
    sample = {}
    with (Path(__file__).with_name("samples") / "reference.csv").open(newline="") as file:
        for row in csv.DictReader(file):
            cell = row["function"], row["algorithm"], row["variant"]
            sample.setdefault(cell, []).append((int(row["seed"]), float(row["best"])))
    return sample


def ours(function, algorithm, variant):
    options = {} if algorithm == "da" else {"variant": variant}
    return final_bests(CLASSES[algorithm], function, RUNS, **options)


def p_value(ours, theirs):
    return ks_2samp(ours, [best for _, best in theirs], method="exact").pvalue


def test_final_bests_are_distributed_like_those_of_the_reference(reference):
    cells = [(name, *variant) for variant in VARIANTS for name in FUNCTIONS]
    assert set(cells) <= set(reference)
    assert all(len(reference[cell]) >= RUNS for cell in cells)
    assert min(seed for runs in reference.values() for seed, _ in runs) >= RUNS  # independent samples
    p_values = {cell: p_value(ours(*cell), reference[cell]) for cell in cells}
    # Holm's first step decides whether any comparison is rejected.
    worst = min(p_values, key=p_values.get)
    assert p_values[worst] > LEVEL / len(cells), worst


@pytest.mark.parametrize(
    ("function", "algorithm", "other"),
    # GWO's variants differ too little for 200 runs: 2,000 of each separate them (D = .09 on Rastrigin's function).
    [("ackley", "alo", "paper"), ("sphere", "goa", "full-distance"), ("sphere", "da", "synchronous")],
)
def test_the_comparison_would_see_another_algorithm(reference, function, algorithm, other):
    assert p_value(ours(function, algorithm, "code"), reference[function, algorithm, other]) < LEVEL / 100


def leaders_of_the_current_generation_alone(leaders, scores, x, f, cascade):
    scores[:] = np.inf
    promote(leaders, scores, x, f, cascade)


def one_coin_for_both_ends(antlions, elite, wheel, lower, upper, t, T, uniforms, steps):
    return walk_ants(antlions, elite, wheel, lower, upper, t, T, uniforms[:, [0, 1, 1, 3, 3]], steps)


@pytest.mark.parametrize(
    ("algorithm", "place", "mistake"),
    [
        ("gwo", "optimizers.gwo.promote", leaders_of_the_current_generation_alone),
        ("alo", "optimizers.alo.walk_ants", one_coin_for_both_ends),
    ],
)
def test_the_comparison_would_see_a_mistake(reference, monkeypatch, algorithm, place, mistake):
    monkeypatch.setattr(place, mistake)
    bests = final_bests.__wrapped__(CLASSES[algorithm], "sphere", RUNS)  # not those of the right algorithm
    assert p_value(bests, reference["sphere", algorithm, "code"]) < LEVEL / 100


@pytest.mark.parametrize(("algorithm", "variant"), [*VARIANTS, ("da", "synchronous")])
def test_the_reference_still_draws_the_sample_that_is_kept(reference, algorithm, variant):
    f = FUNCTIONS["sphere"]
    seed, best = reference["sphere", algorithm, variant][0]
    again = final_best(f, *BOXES[f], D, algorithm, variant, seed, AGENTS, GENERATIONS)
    assert again == pytest.approx(best, rel=1e-9)


def test_the_functions_are_positive_and_vanish_at_their_optima():
    optima = {
        "sphere": np.linspace(-4, 5, D),
        "rastrigin": np.linspace(-2, 2.5, D),
        "rosenbrock": np.ones(D),
        "ackley": np.linspace(15, -12, D),
        "ellipsoid": np.linspace(3.2, -2.8, D),
    }
    rng = np.random.default_rng(1)
    for name, f in FUNCTIONS.items():
        assert 0 <= f(optima[name]) < 1e-12
        for scale in (1e-3, 1.0):
            for x in optima[name] + scale * rng.standard_normal((100, D)):
                assert f(x) > 0
        lower, upper = BOXES[f]
        assert ((optima[name] > lower) & (optima[name] < upper)).all()
