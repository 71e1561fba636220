"""pymoo's algorithms spend the budget to the evaluation, follow the seed alone, and are pymoo's own."""

from importlib import import_module
from pkgutil import iter_modules

import numpy as np
import pytest

from bench import Objective, solve
from bench.contract.seeds import streams
from optimizers.common.family import global_random_state
from optimizers.pymoo import FOLDER, TABLE, pymoo
from tests.optimizers.observed import OPTIMUM, Watched

MEMBERS, PARAMETERS = TABLE["members"], TABLE["parameters"]


def run(name, problem=None, *, budget=400, seed=1, **options):
    return solve(problem or Watched(), pymoo.load(f"pymoo:{name}", **options), budget=budget, seed=seed)


def test_every_algorithm_of_pymoo_is_a_member_or_left_out():
    from pymoo.core.algorithm import Algorithm

    found = {"Optuna"}  # its module fails without the package that it wraps
    for module in iter_modules(import_module(FOLDER).__path__):
        if module.name != "optuna":
            classes = vars(import_module(f"{FOLDER}.{module.name}")).values()
            found |= {
                each.__name__
                for each in classes
                if isinstance(each, type) and issubclass(each, Algorithm) and each.__module__.endswith(module.name)
            }
    assert found == MEMBERS.keys() | set().union(*pymoo.facts["left_out"].values())
    known = {"module", "parameters", "about", "works", "unmapped"}
    assert all(entry.keys() <= known for entry in MEMBERS.values())
    assert {name for entry in MEMBERS.values() for name in entry["parameters"]} >= PARAMETERS.keys()
    assert pymoo.names() == sorted(f"pymoo:{name}" for name in MEMBERS)


@pytest.mark.parametrize(
    ("name", "options", "sizes"),
    [
        ("DE", {"agents": 40}, [40] * 5),
        ("GA", {"agents": 40, "n_offsprings": 20}, [40, *[20] * 8]),
        ("ES", {"n_offsprings": 70}, [10, 70, 70, 50]),
        ("NRBO", {}, [50] * 4),
        ("CMAES", {"agents": 30}, [20, *[30] * 6]),
        ("BRKGA", {"n_elites": 10, "n_offsprings": 60, "n_mutants": 10}, [80, 70, 50]),
    ],
)
def test_a_generation_is_one_batch(name, options, sizes):
    problem = Watched()
    run(name, problem, budget=200, **options)
    assert [len(batch) for batch in problem.batches] == sizes


@pytest.mark.parametrize(
    ("name", "options", "generations"), [("DE", {"F": 0.8, "CR": 0.9}, 30), ("PSO", {"c1": 1.5}, 30), ("GA", {}, 20)]
)
def test_a_run_is_pymoo_s_own(name, options, generations):
    from pymoo.core.problem import Problem
    from pymoo.optimize import minimize

    class Sphere(Problem):
        def _evaluate(self, x, out, *args, **kwargs):
            out["F"] = ((x - OPTIMUM) ** 2).sum(axis=1)

    agents, seed, problem = 20, 5, Watched()
    ours = run(name, problem, budget=agents * generations, seed=seed, agents=agents, **options)
    start, search = streams(seed)
    with global_random_state(search):
        theirs = int(search.integers(1, 2**31))
    solver = getattr(import_module(f"{FOLDER}.{MEMBERS[name]['module']}"), name)
    algorithm = solver(pop_size=agents, sampling=Objective(problem, 1, start).initial(agents), **options)
    box = Sphere(n_var=3, n_obj=1, xl=np.array(Watched().lower.tolist()), xu=np.array(Watched().upper.tolist()))
    found = minimize(box, algorithm, ("n_gen", generations), seed=theirs)
    assert (ours.fun, ours.nfev) == (found.F[0], found.algorithm.evaluator.n_eval)
