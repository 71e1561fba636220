"""Single runs from Python: functions, classes, objects and names."""

from dataclasses import dataclass

import numpy as np
import pytest

from bench import BenchError, Optimizer, load_problem, solve


@dataclass(frozen=True)
class Once(Optimizer):
    share: float = 0.5

    def minimize(self, objective, rng):
        objective(objective.lower + self.share * (objective.upper - objective.lower))


def once(objective, rng):
    objective(objective.initial(1))


def sphere(x):
    return (x**2).sum()


@pytest.mark.parametrize("optimizer", [Once, Once(share=0.5), once, "random-search", lambda o, rng: o(o.initial(30))])
def test_a_function_with_bounds_is_minimised_by_any_kind_of_optimizer(optimizer):
    found = solve(sphere, optimizer, bounds=[(-5, 5)] * 3, budget="100 * d")
    assert found.nfev <= 300
    assert found.fun == pytest.approx((found.x**2).sum())


def test_functions_of_one_point_and_of_many_give_the_same_run():
    one, many = (
        solve(fun, "gwo", bounds=[(-5, 5), (0, 2)], budget=90, seed=2) for fun in (sphere, lambda x: (x**2).sum(axis=1))
    )
    assert (one.fun, one.x.tolist()) == (many.fun, many.x.tolist())


@pytest.mark.parametrize(
    ("problem", "optimizer", "settings", "sentence"),
    [
        (sphere, Once, {}, "the function 'sphere' needs bounds to be a problem"),
        (sphere, Once, {"bounds": [5, 6]}, "bounds must be a pair (lower, upper) for each variable, not [5, 6]"),
        (sphere, Once, {"bounds": [(0, 1)], "budget": 0}, "'budget' must be a whole number from 1"),
        (sphere, object, {"bounds": [(0, 1)]}, "'object' is no optimizer"),
        (3, Once, {}, "'int' is no problem"),
        ("classical-sphere-d2-i1", Once, {"bounds": [(0, 1)]}, "is made already; leave out its bounds and options"),
    ],
)
def test_a_mistake_is_one_sentence(problem, optimizer, settings, sentence):
    with pytest.raises(BenchError) as caught:
        solve(problem, optimizer, **{"budget": 5} | settings)
    assert sentence in str(caught.value)


def test_a_problem_s_own_box_stays_as_it_was_given():
    problem = load_problem("classical-sphere-d2-i1")
    assert solve(problem, Once, budget=1).x.tolist() == ((problem.lower + problem.upper) / 2).tolist()
    assert np.array_equal(problem.lower, load_problem("classical-sphere-d2-i1").lower)
