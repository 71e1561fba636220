"""What every population method here owes the harness: exact budgets, no hidden state, no crash at the edges."""

import numpy as np
import pytest

from bench import solve
from optimizers.alo import ALO
from optimizers.da import DA
from optimizers.goa import GOA
from optimizers.gwo import GWO
from optimizers.random_search import RandomSearch
from tests.optimizers.observed import Watched

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


@each
@pytest.mark.parametrize(
    ("budget", "batches"), [(30, [6] * 5), (33, [6] * 5 + [3]), (6, [6]), (7, [6, 1]), (4, [4]), (1, [1])]
)
def test_spends_the_budget_exactly_in_whole_generations(cls, options, budget, batches):
    problem = Watched()
    result = solve(problem, cls(agents=6, **options), budget=budget, seed=1)
    assert result.nfev == budget
    assert result.stop == "budget"
    assert [len(x) for x in problem.batches] == batches


def test_random_search_is_uniform_in_the_box():
    problem = Watched(lambda x: (x**2).sum(axis=1), [-4, -4], [6, 6])
    solve(problem, RandomSearch(agents=100), budget=20_000, seed=1)
    shares = np.histogram2d(*np.concatenate(problem.batches).T, bins=5, range=[[-4, 6]] * 2)[0] / 20_000
    assert np.abs(shares - 1 / 25).max() < 5 * np.sqrt(0.04 * 0.96 / 20_000)
