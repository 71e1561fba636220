"""What every optimizer owes the harness, those written here and those of libraries: one table, the same tests for each.

The tests of a family check the rest: that a run is the library's, its stops, its options and what it leaves out.
"""

import logging
import pickle
import random
import threading
import warnings
from importlib.metadata import distribution
from importlib.util import find_spec
from inspect import isclass

import numpy as np
import pytest

from bench import load_optimizer, solve
from bench.contract.seeds import global_states
from bench.helpers.bibtex import parse
from bench.helpers.errors import ProblemError
from optimizers import minion, optuna, pymoo, scipy
from tests.optimizers.observed import BEST, LOWER, UPPER, Capped, Recorded, bowl

REGISTERED = distribution("backlash-bench").entry_points.select(group="bench.optimizers")
OWN = sorted(entry.name for entry in REGISTERED if isclass(entry.load()))  # the others are families
MEMBERS = {
    "scipy": list(scipy.MEMBERS),
    "pymoo": list(pymoo.TABLE["members"]),
    "minion": list(minion.TABLE["members"]),
    "optuna": list(optuna.TABLE["members"]),
    "mealpy": ["OriginalGWO", "OriginalABC", "SAP_DE", "OriginalPSO", "BaseGA"],
    # populations, one-shot designs, threads, chains, portfolios, competence maps
    "nevergrad": [
        "DE", "SQP", "CMA", "NGOptBase", "TwoPointsDE", "LhsDE", "DiagonalCMA", "HSDE", "PSO", "OnePlusOne",
        "DiscreteOnePlusOne", "ES", "TBPSA", "NaiveIsoEMNA", "EDA", "cGA", "SPSA", "RandomSearch", "LHSSearch",
        "ScrHammersleySearch", "Cobyla", "Powell", "NelderMead", "RBFGS", "DSproba", "ChainCMASQP", "DS8",
        "MultiCobyla", "ParaPortfolio", "Portfolio", "Shiwa",
    ],
}  # fmt: skip
MODULES = {"minion": "minionpy"}  # where it is not the family's name
SEED_FREE = {"scipy:direct"}
TIMID = {"pymoo:BRKGA", "mealpy:BaseGA"}  # they recombine what they have, and stay where the start was repaired to
OWNS = {"scipy": "virtanen2020", "pymoo": "blank2020", "minion": "muzakka2025", "optuna": "akiba2019",
        "mealpy": "vanthieu2023", "nevergrad": "bennet2021"}  # fmt: skip
USUAL, LITTLE = 230, {"nevergrad": 60, "optuna": 60}  # evaluations of a run, few where they cost much


NAMES = [*OWN, *(f"{family}:{member}" for family, own in MEMBERS.items() for member in own)]
SLOW = NAMES[4 - len(MEMBERS["nevergrad"]) :]
each_optimizer = pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in NAMES]
)


def waves(x):
    d = x.shape[1]
    y = 10 * (x - BEST[:d]) / (UPPER - LOWER)[:d]
    return (y**2 - 10 * np.cos(2 * np.pi * y) + 10).sum(axis=1)


def loaded(name, **options):
    family = name.partition(":")[0]
    module = MODULES.get(family, family)
    if family in MEMBERS and not find_spec(module):
        pytest.skip(f"the extra {family!r} is not installed")
    return load_optimizer(name, **options)


def usual(name):
    """Return the budget of a run of an optimizer."""
    return LITTLE.get(name.partition(":")[0], USUAL)


def run(name, *, on=waves, d=3, budget=None, seed=1, problem=None, **options):
    """Return the result of a run, and the points of its evaluations."""
    problem = problem or Recorded(on, d)
    result = solve(problem, loaded(name, **options), budget=budget or usual(name), seed=seed)
    return result, np.concatenate(problem.points)


@each_optimizer
def test_a_run_is_silent_keeps_the_budget_or_declares_its_stop_and_leaves_nothing_behind(
    name, capfd, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(logging.root, "handlers", [])  # as outside of pytest
    disabled, threads, seen = logging.root.manager.disable, set(threading.enumerate()), set()

    def watched(x):
        seen.add(threading.get_ident())
        return np.where(x[:, 0] > 3, np.inf, waves(x))

    for budget in (1, 7, usual(name))[2 * (name == "nevergrad:NaiveIsoEMNA") :]:  # numpy warns of its few points
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            result, points = run(name, on=watched, budget=budget)
        assert len(points) == result.nfev <= budget
        assert (result.stop == "budget") == (result.nfev == budget)
        assert result.stop != "undeclared"
        assert result.usage.outside_box == 0
    assert capfd.readouterr() == ("", "")
    assert list(tmp_path.iterdir()) == []
    assert (logging.root.handlers, logging.root.manager.disable) == ([], disabled)
    assert seen == {threading.get_ident()}
    assert set(threading.enumerate()) == threads


@each_optimizer
def test_a_run_depends_on_the_seed_alone_and_leaves_the_global_random_states_alone(name):
    runs = []
    for state in (1, 2):
        random.seed(state)
        np.random.seed(state)  # noqa: NPY002 - the global state must not matter
        before = global_states()
        runs.append(run(name)[1])
        assert global_states() == before
    np.testing.assert_array_equal(*runs)
    assert np.array_equal(run(name, seed=2)[1], runs[0]) == (name in SEED_FREE)


@each_optimizer
@pytest.mark.parametrize("value", [np.inf, 3.0])
def test_infinite_values_and_plateaus_are_no_end_of_a_run(name, value):
    result, _ = run(name, on=lambda x: np.full(len(x), value))
    assert result.nfev == usual(name) or result.stop not in ("budget", "undeclared")


@each_optimizer
def test_one_variable_suffices(name):
    if name in ("nevergrad:DiagonalCMA", "nevergrad:CMA"):
        pytest.skip("nevergrad turns to another package in one dimension")
    assert run(name, on=bowl, d=1)[0].fun < (1.0 if name.startswith("nevergrad:") else 0.05)  # of few evaluations


@pytest.mark.parametrize("name", [name for name in NAMES if name not in SLOW])
@pytest.mark.parametrize(("handling", "most"), [("repair", 2.0), ("box", 4.0)])
def test_handling_decides_what_is_evaluated(name, handling, most):
    _, points = run(name, problem=Capped(lambda x: -x[:, 0]), budget=3 * usual(name), handling=handling)
    assert (points[:, 0].max() > 2.0) == (most == 4.0 and name not in TIMID)
    assert points[:, 0].max() <= most


@each_optimizer
def test_it_travels_to_workers_and_is_cited(name):
    optimizer, (family, colon, _) = loaded(name), name.partition(":")
    assert pickle.loads(pickle.dumps(optimizer)) == optimizer
    assert optimizer.__doc__.strip()
    works = [work.key for work in parse(optimizer.bibtex)]
    assert works == sorted(set(works), key=works.index)
    if colon:
        assert OWNS[family] in works
        assert optimizer.code.startswith(f"{MODULES.get(family, family)} ")


@pytest.mark.parametrize(
    "name", ["gwo", "cma-es", "scipy:dual_annealing", "nevergrad:SQP", "pymoo:DE", "mealpy:OriginalGWO",
             "minion:LSHADE", "minion:NLSHADE_RSP", "minion:CMAES", "optuna:TPESampler"]
)  # fmt: skip
def test_an_error_of_the_problem_stays_itself(name):
    def broken(x):
        raise KeyError("no data for this point")

    with pytest.raises(ProblemError, match="no data for this point"):
        run(name, on=broken)
