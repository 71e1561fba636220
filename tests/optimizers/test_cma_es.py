"""cma-es is pycma: the same map into the box, the same run to the last bit, and honest stops."""

import warnings

import cma
import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from bench import BudgetExhausted, FunctionProblem, Objective, load_problem, solve
from bench.contract.seeds import streams
from optimizers.cma_es import CMAES, BoxMap
from tests.optimizers.observed import Watched


def boxes(seed):
    rng = np.random.default_rng(seed)
    lower = rng.normal(size=7) * 10 ** rng.uniform(-3, 3, 7)
    return rng, lower, lower + 10 ** rng.uniform(-4, 4, 7)


@pytest.mark.parametrize("seed", range(20))
def test_the_map_into_the_box_is_pycma_s_to_the_last_bit(seed):
    rng, lower, upper = boxes(seed)
    points = lower + (upper - lower) * rng.normal(0.5, 3.0, (300, 7))
    theirs = cma.BoundTransform([lower, upper])
    np.testing.assert_array_equal(BoxMap(lower, upper)(points), np.array([theirs.repair(x) for x in points]))


@pytest.mark.parametrize("seed", range(20))
def test_a_pre_image_maps_back(seed):
    rng, lower, upper = boxes(seed)
    x = rng.uniform(lower, upper)
    box = BoxMap(lower, upper)
    np.testing.assert_allclose(box(box.inverse(x)[np.newaxis])[0], x, rtol=1e-9, atol=1e-12)


class Capped(Watched):
    """Feasible where the first variable is at most 4."""

    def repair(self, x):
        return np.column_stack([np.minimum(x[:, 0], 4.0), x[:, 1:]])


def plain_pycma(problem, optimizer, budget, seed):
    """Return the stop of a run by pycma's own loop, with its option bounds."""
    points, stream = streams(seed)
    objective = Objective(problem, budget, points)
    width = problem.upper - problem.lower
    options = {
        "popsize": optimizer.population(len(width)), "bounds": [problem.lower, problem.upper], "seed": np.nan,
        "randn": lambda *shape: stream.standard_normal(shape), "verbose": -9, "verb_log": 0, "maxiter": np.inf,
        **({"CMA_stds": width / 4} if len(width) > 1 else {}),
        **({} if optimizer.active else {"CMA_active": False}),
    }  # fmt: skip
    strategy = cma.CMAEvolutionStrategy(optimizer.mean(objective), 1 if len(width) > 1 else width[0] / 4, options)
    while not strategy.stop() and objective.remaining:
        asked = strategy.ask()
        x = np.array(asked)
        values = objective(objective.repair(x) if optimizer.handling == "repair" else x)
        strategy.tell(asked, values.tolist())
    return " ".join(sorted(strategy.stop()))


def ill_conditioned(exponent):
    """Return a problem of that condition, rotated: beyond 1e12 pycma changes its coordinates."""
    scales, rotation = 10 ** np.linspace(0, exponent, 4), np.eye(4) - 0.5
    return Capped(lambda x: (scales * ((x - 1) @ rotation) ** 2).sum(axis=1), [-5] * 4, [5] * 4)


def ellipsoid(dimension):
    """Return a problem whose optimum lies on bounds."""
    return Capped(lambda x: (np.arange(1, dimension + 1) * x**2).sum(axis=1), [0] * dimension, [7] * dimension)


def signature():
    problem = load_problem("signature-12", unit="rpm")
    return Capped(problem.evaluate, problem.lower, problem.upper)


MIDPOINT = {"handling": "box", "start": "midpoint"}


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    ("problem", "options", "generations"),
    [
        (signature(), {"agents": 60, **MIDPOINT}, 100),
        (ill_conditioned(6), {"agents": 4, **MIDPOINT}, 1000),  # pycma mirrors samples below six agents
        (ill_conditioned(14), {"agents": 40}, 500),
        (ill_conditioned(6), {"agents": 40, "active": False}, 200),
        (ellipsoid(1), {}, 200),  # no coordinate-wise scales
        (ellipsoid(7), {"agents": 300, "handling": "box"}, 100),
        (ellipsoid(300), {"agents": 20}, 6),  # pycma injects two points into each generation
    ],
)
def test_a_run_is_pycma_s_own_with_bounds(problem, options, generations):
    optimizer = CMAES(**options)
    budget = generations * optimizer.population(len(problem.lower))
    ours = solve(problem, optimizer, budget=budget, seed=3)
    points, problem.batches = np.vstack(problem.batches), []
    with warnings.catch_warnings(), threadpool_limits(1):  # as solve does: threads of BLAS change last digits
        warnings.simplefilter("ignore")
        stop = plain_pycma(problem, optimizer, budget, seed=3)
    np.testing.assert_array_equal(points, np.vstack(problem.batches))
    assert ours.stop == (stop or "budget")


def test_start_is_the_midpoint_or_a_random_feasible_point():
    problem = FunctionProblem(lambda x: (x**2).sum(axis=1), [0, 0], [1, 1])

    def centre(start):
        seen = []
        watched = FunctionProblem(lambda x: seen.append(x) or (x**2).sum(axis=1), [0, 0], [1, 1], vectorized=True)
        objective = Objective(watched, 500, np.random.default_rng(0))
        with pytest.raises(BudgetExhausted):
            CMAES(agents=500, start=start, sigma=0.01).minimize(objective, np.random.default_rng(1))
        return seen[0].mean(axis=0)

    np.testing.assert_allclose(centre("midpoint"), 0.5, atol=0.003)
    start = Objective(problem, 1, np.random.default_rng(0)).initial(1)[0]
    np.testing.assert_allclose(centre("random"), start, atol=0.003)
