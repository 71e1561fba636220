"""mealpy's algorithms spend the budget to the evaluation, follow the seed alone, and are mealpy's own."""

import warnings

import numpy as np
import pytest

from bench import Objective, solve
from bench.contract.seeds import streams
from bench.helpers.bibtex import parse
from optimizers.common.family import global_random_state
from optimizers.mealpy import TABLE, mealpy
from tests.optimizers.observed import OPTIMUM, Watched

library = pytest.importorskip("mealpy", reason="the extra 'mealpy' is not installed")


def run(name, problem=None, *, budget=400, seed=1, **options):
    return solve(problem or Watched(), mealpy.load(f"mealpy:{name}", **options), budget=budget, seed=seed)


def test_the_members_are_mealpy_s_classes_but_those_left_out():
    listed, left_out = set(library.get_all_optimizers(verbose=False)), set().union(*mealpy.facts["left_out"].values())
    assert {name.partition(":")[2] for name in mealpy.names()} == listed - left_out
    assert listed >= left_out.union(TABLE["no_swarm"], TABLE["works"], *TABLE["remarks"].values())


@pytest.mark.slow
def test_every_member_loads_runs_and_is_silent(capfd):
    problem = Watched()
    for name in mealpy.names():
        optimizer = mealpy.load(name)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert solve(problem, optimizer, budget=130, seed=2).nfev == 130, name
        assert optimizer.__doc__.strip()
        assert [each.key for each in parse(optimizer.bibtex)][-1] == "vanthieu2023"
        assert optimizer.code == f"mealpy {library.__version__}"
    assert capfd.readouterr() == ("", "")


# Beside the usual N at the start and an epoch: 2 N, 1 evaluation an epoch, 6 N at the start, 30 N an epoch.


@pytest.mark.parametrize(
    ("name", "mode", "options"),
    [
        ("OriginalGWO", "single", {}),
        ("OriginalGWO", "swarm", {}),
        ("OriginalPSO", None, {"c1": 1.5, "w": 0.6}),
        ("OriginalSCA", "swarm", {}),
        ("OriginalMVO", "single", {"wep_min": 0.3}),  # one whose population is kept sorted
        ("JADE", "single", {"miu_f": 0.7}),
    ],
)
def test_a_run_is_mealpy_s_own(name, mode, options):
    agents, epochs, seed = 20, 15, 4
    problem = Watched()
    ours = run(name, problem, budget=agents * (epochs + 1), seed=seed, agents=agents, **options,
               **({"mode": mode} if mode else {}))  # fmt: skip
    start, search = streams(seed)
    points = Objective(problem, 1, start).initial(agents)
    model = library.get_all_optimizers(verbose=False)[name](epoch=epochs, pop_size=agents, **options)
    asked = {"obj_func": lambda x: float(((x - OPTIMUM) ** 2).sum()), "minmax": "min", "log_to": None}
    asked["bounds"] = library.FloatVar(Watched().lower.tolist(), Watched().upper.tolist())
    with global_random_state(search):
        theirs = int(search.integers(2**31))
        found = model.solve(asked, mode=mode or "single", starting_solutions=points, seed=theirs)
    assert ours.fun == pytest.approx(found.target.fitness, rel=1e-12)
    np.testing.assert_array_equal(ours.x, found.solution)


@pytest.mark.parametrize(("name", "planned"), [("OriginalGWO", {19}), ("OriginalFFA", None), ("L_SHADE", None)])
def test_the_schedule_ends_with_the_budget(name, planned, monkeypatch):
    solver = type(mealpy.load(f"mealpy:{name}")).solver
    seen, evolve = [], solver.evolve

    def watched(model, epoch):
        seen.append((epoch, model.epoch))
        evolve(model, epoch)

    monkeypatch.setattr(solver, "evolve", watched)
    budget = {"OriginalGWO": 2000, "OriginalFFA": 20 * 30 * 8, "L_SHADE": 2000}[name]
    run(name, budget=budget, agents=100 if name == "OriginalGWO" else 20)
    assert seen[-1][0] == seen[-1][1]
    if planned:
        assert {last for _, last in seen} == planned
