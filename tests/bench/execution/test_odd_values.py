"""Values that honest problems return by mistake: noise that is not declared, -0.0, subclasses, masks."""

import numpy as np
import pytest

from bench import FunctionProblem, Study, load_results, run
from bench.contract.objective import Objective
from bench.storage.folder import Folder

CODE = """
import numpy as np
from bench import Problem

class Array(np.ndarray):
    pass

class Number(float):
    pass

class Odd(Problem):
    def __init__(self, kind):
        self.name, self.variables, self.kind = kind, ("x1", "x2"), kind
        self.lower, self.upper = np.full(2, -1.0), np.full(2, 1.0)
        self.seeded = np.random.default_rng(0)

    def evaluate(self, x):
        values = (x**2).sum(axis=1)
        return {
            "plain": lambda: values,
            "noise": lambda: values + 1e-3 * np.random.default_rng().standard_normal(len(x)),
            "seeded": lambda: values + 1e-3 * self.seeded.standard_normal(len(x)),
            "faint": lambda: values * (1 + 1e-13 * np.random.default_rng().standard_normal(len(x))),
            "batch": lambda: values * (1 + 1e-11 * len(x)),
            "zero": lambda: np.where(values < 0.5, -0.0, values),
            "array": lambda: values.view(Array),
            "numbers": lambda: [Number(value) for value in values],
            "objects": lambda: np.array([Number(value) for value in values], dtype=object),
            "masked": lambda: np.ma.array(values, mask=values < 0.5),
        }[self.kind]()
"""
SAME = ("array", "numbers", "objects")
KINDS = ("plain", "noise", "seeded", "faint", "batch", "zero", "masked", *SAME)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("odd")
    (place / "odd.py").write_text(CODE)
    problems = [{"name": f"{place / 'odd.py'}:Odd", "label": kind, "kind": kind} for kind in KINDS]
    study = {"name": "s", "trials": 2, "budget": 60, "problems": problems, "optimizers": [{"name": "hill-climber"}]}
    return run(Study.from_dict(study), place / "out", n_jobs=1).folder


@pytest.fixture(scope="module")
def frame(folder):
    return load_results(folder).set_index("problem")


@pytest.mark.parametrize("kind", ["noise", "seeded"])
def test_noise_that_is_not_declared_is_named_with_the_remedy(frame, kind):
    assert frame.loc[kind, "status"].eq("failed").all()
    assert frame.loc[kind, "error"].str.contains("has noise that it does not declare: the value ").all()
    assert frame.loc[kind, "error"].str.contains("set noisy = True, and return true values from noiseless").all()


@pytest.mark.parametrize("kind", ["faint", "batch"])
def test_differences_of_rounding_are_no_noise(frame, kind):
    assert frame.loc[kind, "status"].eq("ok").all()


@pytest.mark.parametrize("kind", SAME)
def test_values_of_a_subclass_are_those_of_its_base(folder, frame, kind):
    assert frame.loc[kind, "status"].eq("ok").all()
    assert frame.loc[kind, "fun"].between(0, 0.5).all()


def test_minus_zero_is_stored_as_zero_and_damages_no_row(folder, frame):
    assert Folder(folder).require_sound().sound
    assert np.copysign(1, frame.loc["zero", "fun"]).tolist() == [1, 1]


def test_masked_values_are_refused_instead_of_the_numbers_under_the_mask(frame):
    assert frame.loc["masked", "status"].eq("failed").all()
    assert frame.loc["masked", "error"].str.contains("values of problem 'masked' must be plain numbers").all()


@pytest.mark.parametrize("value", [np.ma.masked, np.ma.array(3.0, mask=True), np.ma.array([3.0], mask=True)])
def test_a_masked_value_of_a_function_fails(value):
    with pytest.raises(TypeError, match="fill the masked ones"):
        FunctionProblem(lambda x: value, [0, 0], [1, 1], vectorized=False).evaluate(np.zeros((1, 2)))


def test_masked_values_of_a_vectorised_function_fail():
    problem = FunctionProblem(lambda x: np.ma.array(x[:, 0], mask=True), [0, 0], [1, 1], vectorized=True)
    with pytest.raises(TypeError, match="fill the masked ones"):
        problem.evaluate(np.zeros((3, 2)))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"evaluate": lambda x: x[:, 0] + 1j}, "values of problem 'f' must be real numbers"),
        ({"evaluate": lambda x: ["1"] * len(x)}, "values of problem 'f' must be real numbers"),
        ({"evaluate": lambda x: None}, "float() argument|returned shape"),
        ({"repair": lambda x: x[:, :1]}, "repaired points of shape"),
        ({"repair": lambda x: "no"}, "repaired points of problem 'f' must be real numbers"),
    ],
)  # fmt: skip
def test_a_problem_s_rubbish_is_named(changes, words):
    problem = FunctionProblem(lambda x: x.sum(axis=1), [0, 0], [1, 1], name="f")
    for name, function in changes.items():
        setattr(problem, name, function)
    objective = Objective(problem, 10, np.random.default_rng(0))
    with pytest.raises((TypeError, ValueError)) as raised:
        objective(objective.initial(3))
    assert any(word in str(raised.value) for word in words.split("|"))
