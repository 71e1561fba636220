"""bbob-noisy against COCO's own package: the functions below the noise, and the noise in distribution."""

import cocoex
import numpy as np
import pytest
from scipy.stats import kstest

from bench import load_problem
from problems.bbob.noisy import BASES, cauchy, gaussian, noise_of, uniform
from tests.problems.bbob.best import function_of

FUNCTIONS = list(BASES)


def theirs(number, dimension, instance):
    return function_of("bbob-noisy", number - 100, dimension, instance)


@pytest.mark.parametrize("number", [number for number in FUNCTIONS if number % 3 == 2])
@pytest.mark.parametrize(("dimension", "instance"), [(2, 1), (5, 7)])
def test_values_without_noise_are_those_of_coco(number, dimension, instance):
    """Cauchy's noise adds a constant, 1000 alpha, to most values in COCO: without it, the true value is left."""
    cauchys = number + 2  # the same function under Cauchy's noise
    problem, function = (
        load_problem(f"bbob-noisy-f{cauchys}-d{dimension}-i{instance}"),
        theirs(cauchys, dimension, instance),
    )
    x = np.random.default_rng(5).uniform(-5, 5, (10, dimension))
    constant = 1000.0 if cauchys > 106 else 10.0
    for row, value in zip(x, problem.noiseless(x), strict=True):
        seen = np.array([function(row) for _ in range(20)]) - constant - 1.01e-8
        assert np.median(seen) == pytest.approx(value, rel=1e-12, abs=1e-9)
    same = load_problem(f"bbob-noisy-f{number}-d{dimension}-i{instance}")
    np.testing.assert_array_equal(same.noiseless(x), problem.noiseless(x))


@pytest.mark.parametrize("number", FUNCTIONS)
def test_the_noise_is_distributed_as_coco_s(number):
    problem, function = load_problem(f"bbob-noisy-f{number}-d5-i3"), theirs(number, 5, 3)
    point = np.full(5, 0.7)
    ours = problem.evaluate(np.tile(point, (2000, 1)), np.random.default_rng(1))
    other = np.array([function(point) for _ in range(2000)])
    # COCO and numpy round differently; Cauchy's noise is constant for most points.
    ours, other = (np.round(each, 6) for each in (ours, other))
    assert kstest(ours, other).pvalue > 1e-4
    assert len(np.unique(ours)) > 50


def test_the_three_models_are_those_of_the_definition():
    f, ones = np.array([2.0, 5.0]), np.ones(2)

    class Fixed:
        def random(self, shape):
            return np.full(shape, 0.25)

        def standard_normal(self, shape):
            return np.full(shape, 2.0)

    np.testing.assert_allclose(gaussian(f, Fixed(), 0.5), f * np.e)
    np.testing.assert_allclose(uniform(f, Fixed(), 0.8, 1.0), f * 0.25 * (1e9 / f) ** 0.2)
    np.testing.assert_allclose(cauchy(f, Fixed(), 0.01, 0.3), f + 0.01 * 1001 * ones)  # struck: 2 / |2|
    np.testing.assert_allclose(cauchy(f, Fixed(), 0.01, 0.2), f + 10 * ones)


def test_moderate_and_severe_noise_have_the_definition_s_parameters():
    assert noise_of(101, 4).keywords == {"beta": 0.01}
    assert noise_of(105, 4).keywords == {"alpha": 0.01 * 0.74, "beta": 0.01}
    assert noise_of(106, 4).keywords == {"alpha": 0.01, "p": 0.05}
    assert noise_of(107, 4).keywords == {"beta": 1.0}
    assert noise_of(129, 4).keywords == {"alpha": 0.74, "beta": 1.0}
    assert noise_of(130, 4).keywords == {"alpha": 1.0, "p": 0.2}


@pytest.mark.parametrize("number", FUNCTIONS)
def test_at_the_optimum_there_is_no_noise(number):
    problem = load_problem(f"bbob-noisy-f{number}-d3-i2")
    best = cocoex.BareProblem("bbob", BASES[number], 3, 2).best_parameter()
    x = np.tile(best, (20, 1))
    assert problem.noiseless(x)[0] == pytest.approx(problem.optimum, abs=1e-9)
    assert problem.evaluate(x, np.random.default_rng(0)).tolist() == pytest.approx([problem.optimum] * 20, abs=1e-9)
