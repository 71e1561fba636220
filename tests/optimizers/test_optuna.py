"""optuna's samplers spend the budget to the evaluation, follow the seed alone, and are optuna's own."""

import inspect
import warnings

import numpy as np
import pytest

from bench import Objective, solve
from bench.contract.seeds import streams
from optimizers.optuna import TABLE, optuna
from tests.optimizers.observed import OPTIMUM, Watched

library = pytest.importorskip("optuna", reason="the extra 'optuna' is not installed")
pytest.importorskip("cmaes", reason="the extra 'optuna' is not installed")

MEMBERS = TABLE["members"]


def run(name, problem=None, *, budget=80, seed=1, **options):
    return solve(problem or Watched(), optuna.load(f"optuna:{name}", **options), budget=budget, seed=seed)


def evaluated(problem):
    return np.vstack(problem.batches)


def test_every_sampler_is_a_member_or_left_out():
    found = {name for name in dir(library.samplers) if name.endswith("Sampler") and not name.startswith("Base")}
    assert found == MEMBERS.keys() | set().union(*optuna.facts["left_out"].values())
    assert optuna.names() == sorted(f"optuna:{name}" for name in MEMBERS)


@pytest.mark.parametrize("name", ["TPESampler", "RandomSampler", "QMCSampler"])
def test_a_run_is_optuna_s_own(name):
    """With optuna's own loop, which asks for one variable after the other, and optuna's defaults."""
    ours, theirs = Watched(), []
    run(name, ours, seed=5)
    start, search = streams(5)
    count = 10 if name == "TPESampler" else 0
    first = Objective(ours, 80, start).initial(count).tolist() if count else []
    options = {"scramble": True} if name == "QMCSampler" else {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        sampler = getattr(library.samplers, name)(seed=int(search.integers(2**32)), **options)
    library.logging.set_verbosity(library.logging.ERROR)
    study = library.create_study(sampler=sampler)
    for point in first:
        study.enqueue_trial({f"x{i}": value for i, value in enumerate(point)})
    box = [(1.0, 5.0), (2.0, 9.0), (-7.0, -1.0)]
    ranges = {f"x{i}": library.distributions.FloatDistribution(*ends) for i, ends in enumerate(box)}
    for _ in range(80):
        trial = study.ask(ranges)
        point = np.array([trial.params[name] for name in ranges])
        theirs.append(point)
        study.tell(trial, float(((point - OPTIMUM) ** 2).sum()))
    np.testing.assert_array_equal(evaluated(ours), np.array(theirs))


@pytest.mark.parametrize("name", MEMBERS)
def test_defaults_are_optuna_s(name):
    known = inspect.signature(getattr(library.samplers, name).__init__).parameters
    optimizer = optuna.load(f"optuna:{name}")
    ours = {each: getattr(optimizer, {"popsize": "agents", "population_size": "agents"}.get(each, each))
            for each in MEMBERS[name]["parameters"]}  # fmt: skip
    if name == "QMCSampler":
        assert ours.pop("scramble")
        assert not known["scramble"].default
    theirs = {each: known[each].default for each in ours}
    if theirs.get("multivariate") is False:  # in older versions, where None means the same
        theirs["multivariate"] = None
    assert ours == theirs
