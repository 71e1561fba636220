"""Objects of a session as plug-ins: which are taken, what they are called, and what is said of others."""

from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest

from bench import BenchError, FunctionProblem, Optimizer, Problem, Study, load_optimizer, load_problem
from bench.contract.optimizer import settings
from bench.plugins import loading, packing


@dataclass(frozen=True)
class Mine(Optimizer):
    """A method of this session."""

    F: float = 0.5
    weights: tuple = ()

    def minimize(self, objective, rng):
        objective(objective.initial(1))


def walk(objective, rng, step=0.1):
    objective(objective.initial(1))


class Walker:
    def walk(self, objective, rng):
        objective(objective.initial(1))

    __call__ = walk


class Asker:
    def __init__(self, objective, rng, agents=2):
        self.ask, self.tell = objective.initial, print

    def ask(self, n):
        """Return points."""

    def tell(self, x, f):
        """Learn nothing."""


class Plane(Problem):
    name, variables, lower, upper = "plane", ("x",), np.zeros(1), np.ones(1)

    def evaluate(self, x):
        return x[:, 0]


def study(problems=("classical-sphere-d2-i1",), optimizers=("gwo",)):
    return Study.from_dict({"name": "mine", "problems": [*problems], "optimizers": [*optimizers]})


def entries(*optimizers):
    return [(entry.name, entry.label, entry.options) for entry in study(optimizers=optimizers).optimizers]


@pytest.mark.parametrize(
    ("thing", "label"),
    [
        (Mine, "Mine"), (Mine(), "Mine"), (walk, "walk"), (Asker, "Asker"), (partial(walk, step=0.2), "walk"),
        (Walker().walk, "walk"), (Walker(), "Walker"), (lambda objective, rng: None, "lambda"),
    ],
)  # fmt: skip
def test_optimizers_of_a_session_are_named_after_their_classes_and_functions(thing, label):
    assert entries(thing) == [(f"python:{label}", label, {})]
    assert isinstance(load_optimizer(f"python:{label}"), Optimizer)
    assert loading.default_label(f"python:{label}") == label
    assert loading.package(f"python:{label}") == f"python:{label}"  # none runs where another one has


def test_what_was_chosen_of_an_optimizer_is_an_option_where_a_file_can_hold_it():
    assert entries(Mine, Mine(F=0.9)) == [("python:Mine", "Mine", {}), ("python:Mine", "Mine[F=0.9]", {"F": 0.9})]
    assert load_optimizer("python:Mine", F=0.25).F == 0.25
    assert entries(Mine(weights=(1, 2))) == [("python:Mine", "Mine", {})]
    assert settings(load_optimizer("python:Mine")) == {"F": 0.5, "weights": (1, 2)}


def test_an_installed_optimizer_is_named_as_such():
    assert entries(load_optimizer("gwo"), load_optimizer("gwo", agents=12)) == [
        ("gwo", "gwo", {}), ("gwo", "gwo[agents=12]", {"agents": 12})
    ]  # fmt: skip
    assert entries(type(load_optimizer("gwo"))) == [("gwo", "gwo", {})]


def test_a_table_gives_an_object_a_label_and_parameters_which_may_be_swept():
    assert entries({"name": Mine, "label": "de", "F": 0.25}) == [("python:de", "de", {"F": 0.25})]
    swept = entries({"name": Mine, "options": {"F": [0.25, 0.75]}})
    assert [label for _, label, _ in swept] == ["Mine[F=0.25]", "Mine[F=0.75]"]
    assert {name for name, _, _ in swept} == {"python:Mine"}
    with pytest.raises(BenchError, match="optimizer 'python:Mine' has no parameter 'G'"):
        study(optimizers=[{"name": Mine, "G": 1}]).optimizer("Mine")


def test_functions_without_names_are_numbered_and_others_twice_are_refused():
    first, second = (lambda x: x.sum()), (lambda x: x.max())  # fmt: skip
    problems = [FunctionProblem(each, [0], [1]) for each in (first, second)]
    assert [entry.label for entry in study(problems).problems] == ["function", "function-2"]
    assert load_problem("python:function-2").evaluate(np.array([[0.25]])).tolist() == [0.25]
    for twice in ([walk, walk], [Mine, Mine()], [problems[0], problems[0]]):
        with pytest.raises(BenchError, match=r"occurs twice among the .*; give one of them another label"):
            study(*([twice] if isinstance(twice[0], Problem) else [["classical-sphere-d2-i1"], twice]))


def test_two_classes_of_one_name_are_kept_apart():
    methods = {"minimize": lambda self, objective, rng: None, "__module__": __name__}
    other = dataclass(frozen=True)(type("Mine", (Mine,), methods))
    pair = entries(Mine, {"name": other, "label": "other"})
    assert [name for name, _, _ in pair] == ["python:Mine", "python:other"]
    with pytest.raises(BenchError, match="'Mine' occurs twice"):
        entries(Mine, other)


def test_a_problem_is_identified_by_its_code_and_data():
    def digest(scale):
        study([FunctionProblem(lambda x: scale * x.sum(), [0], [1], name="mine")])
        return packing.held["problems python:mine"].digest

    assert digest(1.0) == digest(1.0) != digest(2.0)
    assert [entry.label for entry in study([Plane, Plane()][:1]).problems] == ["Plane"]
    assert load_problem("python:Plane").name == "plane"


def test_loading_it_where_it_was_given_changes_nothing_of_it():
    problem, minimize = Plane(), Mine.minimize
    study([problem], [Mine])
    assert load_problem("python:plane") is not problem
    load_optimizer("python:Mine")
    assert Mine.minimize is minimize


@dataclass(frozen=True)
class Abstract(Optimizer):
    """Without minimize."""


class Thawed(Optimizer):
    def minimize(self, objective, rng):
        """Do nothing."""


@pytest.mark.parametrize(
    ("thing", "sentence"),
    [
        (Abstract, "'Abstract' (Abstract) must be a frozen dataclass that implements minimize"),
        (Thawed, "'Thawed' (Thawed) must be a frozen dataclass that implements minimize"),
        (Thawed(), "the class of 'Thawed' must be a frozen dataclass: write @dataclass(frozen=True) above it"),
        (type("Empty", (), {}), "'Empty' is no optimizer: give a name, a subclass of bench.Optimizer"),
        (Plane(), "'plane' is no optimizer"),
        (lambda x: x, "'lambda' must take (objective, rng) first"),
        (len, "'len' must take (objective, rng) first"),
    ],
)
def test_what_is_no_optimizer_is_refused(thing, sentence):
    with pytest.raises(BenchError) as caught:
        study(optimizers=[thing])
    assert sentence in str(caught.value)


@pytest.mark.parametrize(
    ("thing", "sentence"),
    [
        (
            lambda x: x,
            "the function 'lambda' needs bounds to be a problem: bench.FunctionProblem(lambda, lower, upper)",
        ),
        (Mine, "'Mine' is no problem: give a name, a bench.Problem, or a function with bounds"),
        (Mine(), "'Mine' is no problem"),
        (Problem, "'Problem' cannot be made: TypeError: Can't instantiate abstract class"),
    ],
)
def test_what_is_no_problem_is_refused(thing, sentence):
    with pytest.raises(BenchError) as caught:
        study([thing])
    assert sentence in str(caught.value)


@pytest.mark.parametrize("load", [load_optimizer, load_problem])
def test_an_object_of_another_session_has_to_be_given_again(load):
    with pytest.raises(
        BenchError, match=r"'python:gone' stands for an object of a Python session, and no file holds it"
    ):
        load("python:gone")


def test_an_object_that_misses_a_module_here_is_one_sentence(monkeypatch):
    packed = packing.PackedObject(b"cno_such_module\nthing\n.", "0")
    monkeypatch.setitem(packing.held, "optimizers python:far", packed)
    with pytest.raises(BenchError, match="'python:far' cannot be loaded here: ModuleNotFoundError"):
        load_optimizer("python:far")
