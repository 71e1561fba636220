"""The command recommend: on planted optimizers, each good on one kind of functions, and what it refuses."""

import shutil

import numpy as np
import pytest

from bench import Study, Trace, load_problem
from bench.study import Entry
from tests.bench.reports import ended, store

BOWLS = ("sphere", "ellipsoid", "cigar", "discus", "schwefel-1-2", "zakharov")
RUGGED = ("rastrigin", "katsuura", "weierstrass", "schaffer-f6", "schwefel-2-26", "lunacek")
OPTIMIZERS = ("cma-es", "gwo", "random-search")  # good on bowls, on rugged functions, and on none

FILE = """
import numpy as np
from bench import FunctionProblem, Problem


class Bowl(Problem):
    name = "bowl"
    variables = ("x", "y")
    lower, upper = np.full(2, -3.0), np.full(2, 4.0)

    def __init__(self, height=1.0):
        self.height = height

    def evaluate(self, x):
        return self.height * (x**2).sum(axis=1)


ready = FunctionProblem(lambda x: (x**2).sum(axis=1), [-1, -1], [1, 2])
flat = FunctionProblem(lambda x: x[:, 0] * 0, [-1, -1], [1, 2])
number = 3


def broken():
    raise ValueError("no data")
"""


def write(place, name, functions, good, **changes):
    """Write a folder whose optimizers reach the optimum at evaluation 60 where ``good(function, optimizer)``."""
    problems = tuple(Entry(label, label) for label in (f"classical-{each}-d2-i1" for each in functions))
    optimizers = tuple(Entry(label, label) for label in changes.pop("optimizers", OPTIMIZERS))
    first, last = changes.pop("values", (9.0, 2.0))
    study = Study(name, problems, optimizers, **{"trials": 4, "budget": "100 * d"} | changes)

    def row_of(trial):
        function = trial.problem.removeprefix("classical-").removesuffix("-d2-i1")
        optimum = load_problem(trial.problem).optimum
        values = optimum + np.array([first, 0.0 if good(function, trial.optimizer) else last])
        return ended(values[-1], nfev=200, x={"x1": 0.0, "x2": 0.0}, trace=Trace(np.array([1, 60]), values))

    store(place / name, study, row_of)


def kinds(function, optimizer):
    return optimizer == (OPTIMIZERS[0] if function in BOWLS else OPTIMIZERS[1])


@pytest.fixture(scope="module")
def place(tmp_path_factory, testing_plugins):
    place = tmp_path_factory.mktemp("recommend")
    write(place, "kinds", BOWLS + RUGGED, kinds)
    write(place, "equal", BOWLS + RUGGED, lambda function, optimizer: True)
    write(place, "one", BOWLS, kinds, optimizers=("gwo",))
    write(place, "single", BOWLS, kinds, trials=1)
    write(place, "far", BOWLS, lambda function, optimizer: False, values=(1e9, 1e8))
    write(place, "hard", BOWLS + RUGGED, lambda function, optimizer: function == "katsuura", values=(1e9, 1e8))
    (place / "mine.py").write_text(FILE, encoding="utf-8")
    return place


def said(done):
    return " ".join(done.stdout.split())


def test_the_optimizer_of_the_kind_is_recommended_with_the_study_that_tests_it(bench_here, place):
    done = bench_here(
        "recommend", "mine.py:Bowl", "--budget", "100 * d", "--from", "kinds", "--output", "study.toml", cwd=place
    )
    assert done.returncode == 0, done.stderr
    assert "To choose by features of the landscape pays: with each of 12 functions left out" in said(done)
    assert "The advice is cma-es, the best on the most similar problems." in said(done)
    study = Study.load(place / "study.toml")
    assert study.optimizers[0].label == "cma-es"
    assert study.problem("Bowl").dimension == 2
    assert study.budget == "100 * d"


def test_it_says_where_the_choice_is_no_better_than_the_single_best(bench_here, place):
    done = bench_here("recommend", "classical-rosenbrock-d2-i1", "--budget", "150", "--from", "equal", cwd=place)
    assert done.returncode == 0, done.stderr
    assert "These data show no gap between the virtual best and the single best" in said(done)
    assert "is not shown to be better than the single best" in said(done)
    assert "The advice is cma-es, the single best" in said(done)
    assert "looked at after 150 evaluations" in said(done)
    assert '{ name = "classical-rosenbrock-d2-i1" }' in said(done)


@pytest.mark.slow
def test_a_problem_unlike_all_others_is_an_extrapolation(bench_here, place):
    done = bench_here("recommend", "classical-step-d100-i1", "--budget", "100 * d", "--from", "kinds", cwd=place)
    assert "This is an extrapolation" in said(done)


def test_several_folders_are_compared_as_one_study(bench_here, place):
    done = bench_here("recommend", "mine.py:ready", "--budget", "200", "--from", "kinds", "--from", "equal", cwd=place)
    assert done.returncode == 0, done.stderr
    assert "(equal)" in said(done)


def test_features_that_would_take_the_whole_budget_leave_the_single_best(bench_here, place):
    done = bench_here("recommend", "mine.py:flat", "--budget", "100", "--from", "kinds", cwd=place)
    assert done.returncode == 0, done.stderr
    assert "would take 100 evaluations, which is all of the budget of 100" in said(done)


def test_folders_of_problems_that_do_not_load_leave_the_single_best(bench_here, place, monkeypatch):
    monkeypatch.setattr("bench.topics.landscapes.features.PATIENCE", -1.0)
    done = bench_here("recommend", "mine.py:Bowl", "--budget", "200", "--from", "kinds", cwd=place)
    assert done.returncode == 0, done.stderr
    assert "none can be compared by its features" in said(done)
    assert "The advice is the single best on all problems" in said(done)


def test_similar_problems_without_a_target_leave_the_single_best(bench_here, place):
    done = bench_here("recommend", "mine.py:Bowl", "--budget", "200", "--from", "hard", cwd=place)
    assert done.returncode == 0, done.stderr
    assert "No trial on the most similar problems reached a target, so the advice is cma-es" in said(done)


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("mine.py:Bowl", "--budget", "1000", "--from", "kinds"), "had at most 100 d evaluations, fewer than 1,000"),
        (("mine.py:Bowl", "--budget", "200", "--from", "one"), "the folders hold one optimizer"),
        (("mine.py:Bowl", "--budget", "200", "--from", "single"), "every optimizer has two trials"),
        (("mine.py:Bowl", "--budget", "200", "--from", "far"), "no trial of the folders reached any target within 200"),
        (("mine.py:flat", "--budget", "200", "--from", "kinds"), "the same value at all 100 points"),
        (("mine.py:broken", "--budget", "200", "--from", "kinds"), "cannot be made: ValueError: no data"),
        (("mine.py:Bowl", "--budget", "200", "--from", "kinds", "--output", "a.txt"), "must end with .toml"),
    ],
)  # fmt: skip
def test_bad_input_costs_one_sentence(bench_here, place, arguments, reason):
    done = bench_here("recommend", *arguments, cwd=place)
    assert done.returncode == 2
    assert reason in done.stderr
    assert done.stderr.count("\n") == 1


def test_another_file_is_not_overwritten(bench_here, place, tmp_path):
    shutil.copy(place / "mine.py", tmp_path / "kept.toml")
    done = bench_here(
        "recommend", "mine.py:Bowl", "--budget", "100", "--from", "kinds", "--output", tmp_path / "kept.toml", cwd=place
    )
    assert done.returncode == 2
    assert "is there already, with other content" in done.stderr
