"""Plug-ins that compute in the arrays that they are given or own: they move nothing that the harness trusts."""

import numpy as np
import pytest

from bench import FunctionProblem, Study, load_problem, load_results, run, solve

CODE = '''
import numpy as np
from bench import Problem

class Honest(Problem):
    def __init__(self, noise=0.0):
        self.name, self.variables, self.noisy = "mine", ("x1", "x2"), noise > 0
        self.lower, self.upper, self.noise = np.full(2, -1.0), np.full(2, 1.0), noise

    def evaluate(self, x, rng=None):
        values = self.noiseless(x)
        return values if rng is None else values + self.noise * rng.standard_normal(len(x))

    def noiseless(self, x):
        return ((x + 0.9) ** 2).sum(axis=1)

    def repair(self, x):
        return np.clip(x, self.lower, self.upper)

    def describe(self, x):
        return {"radius": float(np.sqrt((x**2).sum()))}

    def violations(self, x):
        return (x[:, :1] + x[:, 1:]) if self.noisy else None

class InPlace(Honest):
    """The same values; every method computes in its argument, or in one array that it keeps."""

    def evaluate(self, x, rng=None):
        values = self.noiseless(x)
        if rng is not None:
            values += self.noise * rng.standard_normal(len(x))
        return values

    def noiseless(self, x):
        self.kept = getattr(self, "kept", np.empty(1000))
        x += 0.9
        x *= x
        self.kept[: len(x)] = x.sum(axis=1)
        return self.kept[: len(x)]

    def repair(self, x):
        return np.clip(x, self.lower, self.upper, out=x)

    def describe(self, x):
        x *= x
        return {"radius": float(np.sqrt(x.sum()))}

    def violations(self, x):
        if not self.noisy:
            return None
        x[:, 0] += x[:, 1]
        return x[:, :1]

class Shrinking(Honest):
    def evaluate(self, x):
        low = self.lower
        low += 0.1
        return super().evaluate(x)
'''


@pytest.fixture
def file(tmp_path):
    (tmp_path / "mine.py").write_text(CODE)
    return str(tmp_path / "mine.py")


def frame(kind, file, place, **options):
    study = Study.from_dict(
        {"name": "s", "trials": 3, "budget": 60, "seed": 2,
         "problems": [{"name": f"{file}:{kind}", "label": "mine", **options}],
         "optimizers": [{"name": "hill-climber"}, {"name": "scatter"}]}
    )  # fmt: skip
    run(study, place / kind, n_jobs=1)
    return load_results(place / kind).drop(columns=["wall_s", "cpu_s", "objective_s", "memory_mb"])


@pytest.mark.parametrize("noise", [0.0, 0.1])
@pytest.mark.slow
def test_a_problem_that_computes_in_place_has_the_values_of_one_that_does_not(noise, file, tmp_path):
    honest, in_place = (frame(kind, file, tmp_path, noise=noise) for kind in ("Honest", "InPlace"))
    assert honest["status"].eq("ok").all()
    assert honest.equals(in_place)
    assert honest["x_x1"].lt(-0.2).any()


def test_a_problem_that_moves_its_own_box_fails_loudly(file, tmp_path):
    frame_of_failures = frame("Shrinking", file, tmp_path)
    assert frame_of_failures["status"].eq("failed").all()
    assert frame_of_failures["error"].str.contains("read-only").all()


def test_a_run_by_solve_keeps_the_box_too(file):
    honest, in_place = (
        solve(load_problem(f"{file}:{kind}"), "random-search", budget=400) for kind in ("Honest", "InPlace")
    )
    assert (in_place.fun, in_place.x.tolist(), in_place.metrics) == (honest.fun, honest.x.tolist(), honest.metrics)
    assert load_problem(f"{file}:InPlace").lower.tolist() == [-1.0, -1.0]


def test_a_list_among_the_options_is_as_new_in_every_trial(tmp_path):
    code = (
        "def mine(objective, rng, steps=None):\n    steps.append(len(steps))\n"
        "    for step in steps:\n        objective(objective.initial(1))\n"
    )
    (tmp_path / "mine.py").write_text(code)
    study = Study.from_dict(
        {"name": "s", "trials": 3, "budget": 60, "problems": [{"name": "sphere-2"}],
         "optimizers": [{"name": f"{tmp_path / 'mine.py'}:mine", "steps": []}]}
    )  # fmt: skip
    run(study, tmp_path / "out", n_jobs=1)
    assert load_results(tmp_path / "out")["nfev"].tolist() == [1, 1, 1]


def test_a_user_s_arrays_stay_writable():
    lower = np.zeros(2)
    problem = FunctionProblem(lambda x: x.sum(axis=1), lower, np.ones(2))
    solve(problem, "random-search", budget=10)
    lower[0] = -5.0
    assert problem.lower.tolist() == [0.0, 0.0]
