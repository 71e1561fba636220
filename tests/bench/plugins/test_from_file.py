"""Optimizers from a file that nobody installed: loaded by name, run beside others, and refused in one sentence."""

import pickle
import sys

import numpy as np
import pytest

from bench import BenchError, Study, load_optimizer, load_problem, run, solve
from bench.plugins import from_file

CODE = '''
from __future__ import annotations

from dataclasses import dataclass

from bench import Optimizer, parameter
from spreads import SPREAD


@dataclass(frozen=True)
class Mine(Optimizer):
    """A class of one's own."""

    agents: int = parameter(4, minimum=2)

    def minimize(self, objective, rng):
        while True:
            objective(objective.initial(self.agents))


class Loose(Optimizer):
    def minimize(self, objective, rng):
        pass


def walk(objective, rng, step: float = SPREAD, greedy=True, target=None):
    """A plain function."""
    x = objective.initial(1)
    best = objective(x)
    while True:
        y = objective.repair(x + step * (objective.upper - objective.lower) * rng.standard_normal(x.shape))
        value = objective(y)
        if value < best or not greedy:
            x, best = y, value


def lacking(objective):
    pass


def demanding(objective, rng, must):
    pass


number = 3
'''


@pytest.fixture
def mine(tmp_path):
    (tmp_path / "mine.py").write_text(CODE)
    (tmp_path / "spreads.py").write_text("SPREAD = 0.1")  # no other test has a module of this name
    yield tmp_path / "mine.py"
    sys.path[:] = [entry for entry in sys.path if entry != str(tmp_path)]
    sys.modules.pop("spreads", None)


def test_a_class_and_a_function_of_a_file_are_optimizers(mine):
    assert load_optimizer(f"{mine}:Mine", agents=7).agents == 7
    assert solve("sphere-2", f"{mine}:walk", budget=300, seed=1).fun < 1e-2
    fast, slow = (
        solve("sphere-2", load_optimizer(f"{mine}:walk", step=step), budget=300, seed=1).fun for step in (0.05, 1e-6)
    )
    assert fast < slow
    assert load_optimizer(f"{mine}:walk", target=0.1).target == 0.1


def test_they_pickle_by_their_name(mine):
    for name in ("Mine", "walk"):
        optimizer = load_optimizer(f"{mine}:{name}")
        assert pickle.loads(pickle.dumps(optimizer)) == optimizer
        assert str(mine).encode() in pickle.dumps(optimizer)


def test_an_edited_file_is_loaded_anew(mine):
    assert load_optimizer(f"{mine}:Mine").agents == 4
    mine.write_text(CODE.replace("parameter(4", "parameter(5"))
    assert load_optimizer(f"{mine}:Mine").agents == 5


@pytest.mark.parametrize(
    ("name", "options", "said"),
    [
        ("mine.py:Mne", {}, "holds no optimizer called 'Mne'; did you mean 'Mine'?"),
        ("mine.py:", {}, "holds no optimizer called ''"),
        ("mine.py:number", {}, "'{}:number' is no optimizer: give a name"),
        ("mine.py:Loose", {}, "must be a frozen dataclass"),
        ("mine.py:lacking", {}, "must take (objective, rng) first"),
        ("mine.py:demanding", {}, "parameter 'must' of '{}:demanding' must be a keyword with a default"),
        ("mine.py:Mine", {"agents": 1}, "parameter 'agents' of Mine must be at least 2, not 1"),
        ("mine.py:walk", {"stepp": 1}, "has no parameter 'stepp'; did you mean 'step'?"),
        ("mine.py:walk", {"greedy": "very"}, "parameter 'greedy' of walk must be true or false, not 'very'"),
        ("mine.py:walk", {"step": "far"}, "parameter 'step' of walk must be a number, not 'far'"),
        ("nobody.py:Mine", {}, "nobody.py cannot be read: No such file or directory"),
        ("faulty.py:Mine", {}, "faulty.py failed to load: ZeroDivisionError: division by zero"),
    ],
)
def test_what_is_wrong_with_a_file_is_one_sentence(mine, name, options, said):
    (mine.parent / "faulty.py").write_text("1 / 0")
    with pytest.raises(BenchError) as caught:
        load_optimizer(str(mine.parent / name), **options)
    assert said.format(mine) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("code", "said"),
    [
        (CODE, "add the class or function: {}:Mine; it holds Mine, Loose, walk"),
        ("raise SystemExit", "add the class or function: {}:ClassName"),
        ("def", "cannot be read as Python: "),
    ],
)
def test_a_file_without_its_class_is_refused_and_not_run(tmp_path, code, said):
    (tmp_path / "own.py").write_text(code)
    path = str(tmp_path / "own.py")
    with pytest.raises(BenchError) as caught:
        load_optimizer(path)
    assert said.format(path) in str(caught.value)
    assert "spreads" not in sys.modules


PROBLEM = """
from dataclasses import dataclass
import numpy as np
from bench import Problem


@dataclass(frozen=True)
class Bowl(Problem):
    height: float = 1.0
    name = "bowl"
    variables = ("x", "y")
    lower, upper = np.full(2, -3.0), np.full(2, 4.0)

    def evaluate(self, x):
        return self.height * (x**2).sum(axis=1)
"""


def test_a_problem_of_a_file_takes_options_and_an_edited_file_is_another_one(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(PROBLEM, encoding="utf-8")
    problem = load_problem(f"{path}:Bowl", height=3)
    assert problem.evaluate(np.ones((1, 2))) == [6]
    path.write_text(PROBLEM.replace("x**2", "x**2 / 2"), encoding="utf-8")
    assert load_problem(f"{path}:Bowl").evaluate(np.ones((1, 2))) == [1]


@pytest.mark.parametrize(
    ("code", "kind"),
    [
        ("class Mine(bench.Problem): pass", True),
        ("class Base(FunctionProblem): pass\nclass Mine(Base): pass", True),
        ("def Mine(scale=1): return problem", True),
        ("Mine = bench.FunctionProblem(f, [0], [1])", True),
        ("class Mine(bench.Optimizer): pass", False),
        ("def Mine(objective, rng, step=0.1): pass", False),
        ("raise SystemExit", False),
    ],
)
def test_the_text_of_a_file_says_whether_it_holds_a_problem(tmp_path, code, kind):
    (tmp_path / "mine.py").write_text(code)
    assert from_file.is_problem(f"{tmp_path / 'mine.py'}:Mine") is kind


def test_two_files_that_import_other_modules_of_one_name_are_refused(tmp_path):
    for folder, text in (("p", f"import namesake_of_bowl\n{PROBLEM}"), ("o", f"import namesake_of_bowl\n{ANY}")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "mine.py").write_text(text, encoding="utf-8")
        (tmp_path / folder / "namesake_of_bowl.py").write_text("A = 1")
    study = Study.from_dict(
        {"name": "s", "trials": 1, "budget": 20, "problems": [{"name": f"{tmp_path}/p/mine.py:Bowl"}],
         "optimizers": [{"name": f"{tmp_path}/o/mine.py:any"}]}
    )  # fmt: skip
    with pytest.raises(BenchError, match=r"o/mine.py imports .* and another plug-in imports .*rename one of them"):
        run(study, tmp_path / "out", n_jobs=1)


ANY = "def any(objective, rng):\n    objective(objective.initial(2))\n"
