"""Optimizers that are functions, that ask and tell, or that take budget and dim."""

import inspect
import random
from dataclasses import dataclass

import numpy as np
import pytest

from bench import AskTell, BenchError, FunctionProblem, compare, load_optimizer, solve
from bench.contract.optimizer import settings


@pytest.fixture
def sphere():
    return FunctionProblem(lambda x: (x**2).sum(axis=1) + 0.1, [-2.0, -1.0, -3.0], [1.0, 3.0, 2.0])


class Recorder:
    """Asks for random points and notes the shapes of what it is told."""

    def __init__(self, objective, rng, agents=1):
        self.rng, self.dimension, self.agents = rng, objective.dimension, agents
        self.seen = []
        searches.append(self)

    def ask(self, n):
        assert n == self.agents
        return self.rng.random((n, self.dimension))

    def tell(self, x, f):
        self.seen.append((x.shape, f.shape))


searches = []


@dataclass(frozen=True)
class Recording(AskTell):
    agents: int = 4

    def start(self, objective, rng):
        return Recorder(objective, rng, self.agents)


def test_each_trial_has_a_state_of_its_own_which_is_asked_for_the_agents_until_the_budget_ends(sphere):
    optimizer = Recording()
    searches.clear()
    first, again = (solve(sphere, optimizer, budget=10) for _ in range(2))
    assert [search.seen for search in searches] == [[((4, 3), (4,))] * 2] * 2
    assert first.fun == again.fun == solve(sphere, Recording, budget=10).fun
    assert vars(optimizer) == {"agents": 4}


def test_a_class_that_asks_and_tells_is_an_optimizer_whose_further_arguments_are_parameters(sphere):
    searches.clear()
    assert solve(sphere, Recorder, budget=3).nfev == 3
    assert searches[0].seen == [((1, 3), (1,))] * 3
    with pytest.raises(BenchError, match=r"'Strange' must take \(objective, rng\) first"):
        solve(sphere, type("Strange", (), {"ask": len, "tell": len}), budget=3)


def test_cma_is_an_optimizer_in_ten_lines(sphere):
    import cma

    class PyCMA(cma.CMAEvolutionStrategy):
        def __init__(self, objective, rng, agents=8):
            box = [objective.lower, objective.upper]
            options = {"bounds": box, "popsize": agents, "seed": int(rng.integers(1, 2**31)), "verbose": -9}
            super().__init__(objective.initial(1)[0], 0.5, options)

        def tell(self, x, f):
            super().tell(list(x), list(f))

    assert solve(sphere, PyCMA, budget=400).fun == pytest.approx(0.1, abs=1e-3)


def test_optuna_is_one(sphere):
    optuna = pytest.importorskip("optuna")
    optuna.logging.set_verbosity(optuna.logging.ERROR)

    class TPE:
        def __init__(self, objective, rng):
            box = zip(objective.lower, objective.upper, strict=True)
            self.space = {f"x{j}": optuna.distributions.FloatDistribution(*ends) for j, ends in enumerate(box)}
            self.study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=int(rng.integers(2**31))))

        def ask(self, n):
            self.trial = self.study.ask(self.space)
            return list(self.trial.params.values())

        def tell(self, x, f):
            self.study.tell(self.trial, f[0])

    assert solve(sphere, TPE, budget=30).nfev == 30


def test_a_function_takes_its_keywords_as_parameters(sphere):
    def look(objective, rng, n=2, *, scale=1.0):
        objective(np.clip(scale * rng.standard_normal((n, 3)), objective.lower, objective.upper))

    assert solve(sphere, look, budget=9).nfev == 2


class Called:
    """The shape of LLaMEA and BLADE; draws from the global random states."""

    def __init__(self, budget=10000, dim=10, scale=1.0):
        self.budget, self.dim, self.scale = budget, dim, scale

    def __call__(self, func):
        f, x = np.inf, None
        for _ in range(self.budget):
            point = np.random.uniform(func.bounds.lb, func.bounds.ub) * self.scale * random.random()  # noqa: NPY002
            if (value := func(point)) < f:
                f, x = value, point
        return f, x


def test_a_class_of_budget_and_dim_is_an_optimizer_that_its_seed_repeats(sphere):
    state = random.getstate(), np.random.get_state()[1].tolist()  # noqa: NPY002
    one, again, other = (solve(sphere, Called, budget=20, seed=seed) for seed in (1, 1, 2))
    assert one.nfev == 20
    assert one.fun == again.fun != other.fun
    assert (random.getstate(), np.random.get_state()[1].tolist()) == state  # noqa: NPY002


def test_its_further_arguments_are_parameters_and_studies_take_it_from_files(sphere, tmp_path):
    file = tmp_path / "called.py"
    file.write_text("import random\nimport numpy as np\n\n" + inspect.getsource(Called))
    loaded = load_optimizer(f"{file}:Called", scale=0.5)
    assert settings(loaded) == {"scale": 0.5}
    both = {"object": Called, "file": f"{file}:Called"}
    frame = compare(sphere, both, trials=2, budget=20, n_jobs=1, output=tmp_path / "compared").frame
    assert frame["status"].tolist() == ["ok"] * 4


def test_each_call_after_the_end_of_the_budget_is_refused_and_not_evaluated(sphere):
    class Greedy(Called):
        def __call__(self, func):
            for _ in range(100):
                try:
                    func(func.bounds.lb)
                except BaseException as error:
                    caught.append(type(error).__name__)

    caught = []
    assert solve(sphere, Greedy, budget=20).nfev == 20
    assert caught == ["BudgetExhausted"] * 80
