"""nevergrad's optimizers run as nevergrad runs them, within the budget, from the seed alone, and leave no trace."""

import time

import numpy as np
import pytest

from bench import solve
from bench.contract.seeds import streams
from optimizers.nevergrad import nevergrad
from tests.optimizers.observed import LOWER, UPPER, Recorded, bowl

ng = pytest.importorskip("nevergrad", reason="the extra 'nevergrad' is not installed")


def run(name, *, on=bowl, d=3, budget=60, seed=1, **options):
    problem = Recorded(on, d)
    result = solve(problem, nevergrad.load(f"nevergrad:{name}", **options), budget=budget, seed=seed)
    return result, np.concatenate(problem.points), problem.sizes


def test_every_member_loads_and_says_what_it_is():
    names = nevergrad.names()
    assert len(names) > 350
    assert names == sorted(set(names))
    for name in names:
        loaded = nevergrad.load(name)
        assert loaded.__doc__
        assert "bennet2021" in loaded.bibtex
        assert loaded.code == f"nevergrad {ng.__version__}"


def test_differential_evolution_is_nevergrad_s():
    ours = run("TwoPointsDE", budget=300, seed=4)[1]
    start, search = streams(4)
    search.integers(2**32)  # the seed of the global random states
    space = ng.p.Array(init=LOWER + (UPPER - LOWER) * start.random((1, 3))[0], lower=LOWER, upper=UPPER)
    space.random_state = np.random.RandomState(int(search.integers(2**32)))
    theirs = []
    optimizer = ng.optimizers.TwoPointsDE(space, budget=300)
    optimizer.minimize(lambda x: theirs.append(x.copy()) or float(bowl(x[np.newaxis])[0]))
    np.testing.assert_array_equal(ours, theirs)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["SQP", "RPowell", "DSproba", "DS8", "ParaPortfolio", "NGOptBase"])
def test_a_thread_s_pace_changes_nothing(name, monkeypatch):
    from nevergrad.optimization import recaster

    before = run(name, d=2)[1]
    answer, tell = recaster._MessagingThread._fake_callable, recaster.SequentialRecastOptimizer._internal_tell_candidate
    for owner, method in ((recaster._MessagingThread, answer), (recaster.SequentialRecastOptimizer, tell)):
        with monkeypatch.context() as patch:
            patch.setattr(owner, method.__name__, slowed(method))
            np.testing.assert_array_equal(run(name, d=2)[1], before)


def slowed(method):
    def then_waits(*args):
        value = method(*args)
        time.sleep(0.001)
        return value

    return then_waits
