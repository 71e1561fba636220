"""minionpy's algorithms spend the budget to the evaluation, follow the seed alone, and are minionpy's own."""

from importlib import import_module

import numpy as np
import pytest

from bench import Objective, solve
from bench.contract.seeds import streams
from optimizers.minion import TABLE, minion
from tests.optimizers.observed import OPTIMUM, Watched

library = pytest.importorskip("minionpy", reason="the extra 'minion' is not installed")

MEMBERS = TABLE["members"]
POPULATIONS = [name for name, entry in MEMBERS.items() if not entry.get("from_point")]
ALIASES = {"Differential_Evolution": "DE", "Dual_Annealing": "DA"}


def run(name, problem=None, *, budget=400, seed=1, **options):
    return solve(problem or Watched(), minion.load(f"minion:{name}", **options), budget=budget, seed=seed)


def evaluated(problem):
    return np.vstack(problem.batches)


def test_every_algorithm_of_minionpy_is_a_member_or_left_out():
    module = import_module("minionpy.algorithms")
    kinds = [each for each in vars(module).values() if isinstance(each, type)]
    base = {module.MinimizerBase, module.Minimizer}
    found = {ALIASES.get(each.__name__, each.__name__) for each in kinds if issubclass(each, module.MinimizerBase)}
    found -= {each.__name__ for each in base}
    left_out = set().union(*minion.facts["left_out"].values())
    assert found == (MEMBERS.keys() | left_out) - {"NLSHADE_LBC"}
    assert not MEMBERS.keys() & left_out
    assert minion.names() == sorted(f"minion:{name}" for name in MEMBERS)
    known = {"about", "works", "parameters", "unmapped", "from_point"}
    assert all(entry.keys() <= known for entry in MEMBERS.values())
    assert {name for entry in MEMBERS.values() for name in entry["parameters"]} >= TABLE["parameters"].keys()


@pytest.mark.parametrize("name", ["LSHADE", "JADE", "NLSHADE_RSP", "CMAES", "j2020"])
def test_a_run_is_minionpy_s_own(name):
    """With minionpy's own defaults, so that the declared ones are checked by whole runs."""
    seed, budget, agents, ours = 5, 600, 40, Watched()
    options = {"agents": agents} if name in POPULATIONS else {}
    run(name, ours, budget=budget, seed=seed, **options)
    start, search = streams(seed)
    points = Objective(ours, 1, start).initial(agents if options else 1).tolist()
    theirs = []

    def sphere(x):
        theirs.extend(x)
        return ((np.array(x) - OPTIMUM) ** 2).sum(axis=1).tolist()

    library.Minimizer(
        func=sphere, bounds=[(1.0, 5.0), (2.0, 9.0), (-7.0, -1.0)], x0=points, algo=name, maxevals=budget,
        seed=int(search.integers(2**31)), options={"population_size": agents} if options else {},
    ).optimize()  # fmt: skip
    np.testing.assert_array_equal(evaluated(ours), np.array(theirs)[:budget])


@pytest.mark.parametrize("name", MEMBERS)
def test_the_declared_defaults_are_minionpy_s(name):
    def points(options):
        seen = []

        def sphere(x):
            seen.extend(x)
            return (np.array(x) ** 2).sum(axis=1).tolist()

        library.Minimizer(
            func=sphere, bounds=[(-5.0, 4.0)] * 5, x0=[[2.0] * 5], algo=name, maxevals=1500, seed=4, options=options
        ).optimize()
        return seen

    assert points(MEMBERS[name]["parameters"]) == points({})
