"""What every population method here owes the harness: exact budgets, no hidden state, no crash at the edges."""

import dataclasses

import numpy as np
import pytest

from bench import FunctionProblem, solve
from bench.objective import Objective
from optimizers.alo import ALO
from optimizers.da import DA
from optimizers.goa import GOA
from optimizers.gwo import GWO
from optimizers.random_search import RandomSearch

VARIANTS = [
    pytest.param(cls, options, id="-".join([cls.__name__, *options.values()]))
    for cls, options in [
        (GWO, {}),
        (GWO, {"variant": "cascade"}),
        (ALO, {}),
        (ALO, {"variant": "paper"}),
        (GOA, {}),
        (GOA, {"variant": "full-distance"}),
        (DA, {}),
        (RandomSearch, {}),
    ]
]
each = pytest.mark.parametrize(("cls", "options"), VARIANTS)


class Recorded(FunctionProblem):
    """A function that keeps the batches it is asked for."""

    def __init__(self, fun=lambda x: (x**2).sum(axis=1), d=3, lower=-4.0, upper=6.0):
        super().__init__(fun, [lower] * d, [upper] * d)
        self.batches = []

    def evaluate(self, x):
        self.batches.append(x.copy())
        return super().evaluate(x)


def minimum(cls):
    return next(field.metadata["minimum"] for field in dataclasses.fields(cls) if field.name == "agents")


@each
@pytest.mark.parametrize(
    ("budget", "batches"), [(30, [6] * 5), (33, [6] * 5 + [3]), (6, [6]), (7, [6, 1]), (4, [4]), (1, [1])]
)
def test_spends_the_budget_exactly_in_whole_generations(cls, options, budget, batches):
    problem = Recorded()
    result = solve(problem, cls(agents=6, **options), budget=budget, seed=1)
    assert result.nfev == budget
    assert result.stop == "budget"
    assert [len(x) for x in problem.batches] == batches


@each
def test_returns_after_the_last_generation_of_a_budget_of_whole_ones(cls, options):
    objective = Objective(Recorded(), 24, np.random.default_rng(1))
    cls(agents=6, **options).minimize(objective, np.random.default_rng(2))  # raises nothing
    assert objective.remaining == 0


@each
def test_the_start_comes_from_the_objective(cls, options):
    problem = Recorded()
    cls(agents=6, **options).minimize(Objective(problem, 12, np.random.default_rng(3)), np.random.default_rng(4))
    np.testing.assert_array_equal(problem.batches[0], Objective(problem, 1, np.random.default_rng(3)).initial(6))


EDGES = {
    "plateau": lambda x: np.ones(len(x)),
    "zero": lambda x: np.zeros(len(x)),
    "infinite": lambda x: np.full(len(x), np.inf),
    "nan": lambda x: np.full(len(x), np.nan),
    "partly infinite": lambda x: np.where(x[:, 0] > 0, np.inf, (x**2).sum(axis=1)),
    "negative": lambda x: (x**2).sum(axis=1) - 1000,
    "mixed signs": lambda x: x.sum(axis=1),
    "tiny": lambda x: (x**2).sum(axis=1) * 1e-310,
    "huge": lambda x: (x**2).sum(axis=1) * 1e306,
}


@each
@pytest.mark.parametrize("d", [1, 4])
@pytest.mark.parametrize("edge", EDGES)
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_no_edge_of_the_values_breaks_it(cls, options, d, edge):
    problem = Recorded(EDGES[edge], d)
    result = solve(problem, cls(agents=minimum(cls), **options), budget=12 * minimum(cls), seed=1)
    assert result.nfev == 12 * minimum(cls)
    assert result.outside_box == 0
    assert np.isfinite(np.concatenate(problem.batches)).all()


def test_random_search_is_uniform_in_the_box():
    problem = Recorded(d=2)
    solve(problem, RandomSearch(agents=100), budget=20_000, seed=1)
    shares = np.histogram2d(*np.concatenate(problem.batches).T, bins=5, range=[[-4, 6]] * 2)[0] / 20_000
    assert np.abs(shares - 1 / 25).max() < 5 * np.sqrt(0.04 * 0.96 / 20_000)
