"""Each optimizer evaluates the very points that the plain reference evaluates, from the same draws."""

from collections import Counter

import numpy as np
import pytest

from bench.contract.objective import Objective
from optimizers.alo import ALO, random_walks
from optimizers.da import DA
from optimizers.goa import EPS, GOA, social_force, social_forces
from optimizers.gwo import GWO
from tests.optimizers import reference
from tests.optimizers.observed import Watched


class Ordered(Watched):
    """Feasible where the variables increase: the repair sorts them."""

    def repair(self, x):
        return np.sort(super().repair(x), axis=1)


def bowl(x):
    return float(sum((k + 1) * (v - 1.5) ** 2 for k, v in enumerate(x))) + 1.0


def steps(x):
    """Ties everywhere, and zeros, of which the roulette's weight is infinite."""
    return float(np.floor(bowl(x) / 25))


def signed(x):
    return bowl(x) - 40.0


def cliff(x):
    return np.inf if x[0] < 0 else bowl(x)


def compare(optimizer, plain, problem, generations, **options):
    """Assert that both evaluate the same points, generation by generation; return these."""
    N = optimizer.agents
    problem.batches = []
    optimizer.minimize(Objective(problem, N * generations, np.random.default_rng(11)), np.random.default_rng(12))
    start = Objective(problem, 1, np.random.default_rng(11)).initial(N)

    def confine(x):
        clipped = np.clip(x, problem.lower, problem.upper)
        return problem.repair(clipped) if optimizer.handling == "repair" else clipped

    f = problem._fun
    expected = plain(f, confine, problem.lower, problem.upper, start, generations, np.random.default_rng(12), **options)
    assert len(problem.batches) == len(expected) == generations
    for t, (ours, theirs) in enumerate(zip(problem.batches, expected, strict=True)):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * 100 ** min(t, 2), err_msg=f"generation {t + 1}")
    return expected


def make(kind, f, d):
    return kind(f, np.linspace(-4, -3, d), np.linspace(5, 6, d), vectorized=False)


def nowhere(x):
    return np.inf


FUNCTIONS = [bowl, steps, signed, cliff, nowhere]
SHAPES = [(Watched, 1), (Watched, 2), (Watched, 7), (Ordered, 3)]
everywhere = pytest.mark.parametrize("f", FUNCTIONS)
shaped = pytest.mark.parametrize(("kind", "d"), SHAPES)


@everywhere
@shaped
@pytest.mark.parametrize("variant", ["code", "cascade"])
def test_gwo(f, kind, d, variant):
    compare(GWO(agents=9, variant=variant), reference.gwo, make(kind, f, d), 10, variant=variant)


@everywhere
@shaped
@pytest.mark.parametrize("variant", ["code", "paper"])
def test_alo(f, kind, d, variant):
    compare(ALO(agents=6, variant=variant), reference.alo, make(kind, f, d), 21, variant=variant)


def test_alo_walks_longer_than_one_word_and_no_multiple_of_a_byte():
    compare(ALO(agents=4), reference.alo, make(Watched, bowl, 2), 70)


def test_alo_sorts_ties_stably():
    compare(ALO(agents=40), reference.alo, make(Watched, lambda x: steps(x) + 1, 2), 4)


@everywhere
@shaped
@pytest.mark.parametrize("variant", ["code", "full-distance"])
def test_goa(f, kind, d, variant):
    compare(GOA(agents=8, variant=variant), reference.goa, make(kind, f, d), 8, variant=variant)


@everywhere
@shaped
def test_da(f, kind, d):
    compare(DA(agents=9), reference.da, make(kind, f, d), 10)


class Edge(Watched):
    """Feasible only on one bound, where DA finds no enemy and keeps the one at the origin."""

    def repair(self, x):
        x = super().repair(x)
        x[:, 0] = self.lower[0]
        return x


def test_da_without_a_point_inside_the_bounds():
    compare(DA(agents=9), reference.da, make(Edge, bowl, 2), 10)


def test_the_comparison_of_da_takes_every_branch():
    seen = Counter()
    compare(DA(agents=9), reference.da, make(Watched, bowl, 2), 10, seen=seen)
    compare(DA(agents=9), reference.da, make(Watched, bowl, 7), 10, seen=seen)
    branches = {"far, swarm", "far, alone", "close, swarm", "close, alone", "threatened", "safe"}
    assert branches | {"enemy on the bounds", "equal in a component"} == set(seen)


@pytest.mark.parametrize("optimizer", [GWO, ALO, GOA, DA])
def test_handling_box_leaves_the_problems_own_rule_out(optimizer):
    plain = getattr(reference, optimizer.__name__.lower())
    batches = compare(optimizer(agents=6, handling="box"), plain, make(Ordered, bowl, 3), 6)
    assert any((np.diff(x, axis=1) < 0).any() for x in batches[1:])


@pytest.mark.parametrize("T", [1, 2, 7, 8, 9, 63, 64, 65, 130])
def test_walks_by_bytes_are_walks_by_steps(T):
    steps = np.random.default_rng(T).integers(256, size=(3, -(-T // 64) * 8), dtype=np.uint8)
    X = np.zeros((3, T + 1))
    X[:, 1:] = np.cumsum(2.0 * np.unpackbits(steps, axis=1, count=T, bitorder="little") - 1, axis=1)
    for t in range(1, T + 1):
        above, width = random_walks(steps, t, T)
        assert above.tolist() == (X[:, t - 1] - X.min(axis=1)).tolist()
        assert width.tolist() == np.ptp(X, axis=1).tolist()


@pytest.mark.parametrize("N", [1, 2, 37])
@pytest.mark.parametrize("width", [1, 2, 3])
def test_social_forces_are_summed_one_after_another(N, width):
    """To the last bit: the compiled loops change no order of a sum."""
    x = np.random.default_rng(N).uniform(-9, 9, (6, N))
    S = np.zeros((6, N))
    for group in range(0, 6, width):
        members = range(group, group + width)
        for j in range(N):
            square = np.zeros(N)
            for k in members:
                square += (x[k, j] - x[k]) * (x[k, j] - x[k])
            for i, D in enumerate(np.sqrt(square)):
                for k in members:
                    S[k, i] += social_force(D) / (D + EPS) * (x[k, j] - x[k, i])
    np.testing.assert_array_equal(social_forces(x, width), S)
