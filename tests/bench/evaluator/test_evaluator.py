"""The evaluator of generated optimizers: scores, errors, the shapes that it takes, the held-out problems."""

import json
import pickle
from types import SimpleNamespace

import numpy as np
import pytest

import bench
from bench import BenchError, Evaluator, FunctionProblem
from bench.evaluator.found import LEAST, LONGEST
from bench.sandbox import bubblewrap

TRAIN, TEST = ("classical-cigar-d2-i1", "classical-ackley-d2-i1"), "classical-cigar-d2-i2"
CALLED = """
import random
import numpy as np

class Search:
    def __init__(self, budget, dim):
        self.budget, self.dim = budget, dim

    def __call__(self, func):
        f, x = np.inf, None
        for _ in range(self.budget):
            y = np.random.uniform(func.bounds.lb, func.bounds.ub) * random.choice([1, 0.5])
            value = func(y)
            if value < f:
                f, x = value, y
        return f, x

def helper(one, other):
    return one
"""
FUNCTION = """
def search(objective, rng):
    while True:
        objective(objective.initial(3))
"""
ASKING = """
class Asking:
    def __init__(self, objective, rng):
        self.objective = objective

    def ask(self, n):
        return self.objective.initial(n)

    def tell(self, x, f):
        pass
"""
OPTIMIZER = """
from dataclasses import dataclass
from bench import Optimizer

@dataclass(frozen=True)
class Mine(Optimizer):
    points: int = 3

    def minimize(self, objective, rng):
        while True:
            objective(objective.initial(self.points))
"""


@pytest.fixture(scope="module")
def judge():
    with Evaluator(TRAIN, TEST, budget=60, timeout=60, n_jobs=1, sandbox=False) as made:
        yield made


@pytest.mark.parametrize("source", [CALLED, FUNCTION, ASKING, OPTIMIZER], ids=["called", "function", "asking", "class"])
def test_every_shape_has_a_score_which_is_the_same_again(judge, source):
    assert judge.map([]) == []
    found, again = judge.map([source, source])
    assert (found.error, found.notes) == ("", ())
    assert 0 < found.score == again.score < 1
    assert found.frame["nfev"].tolist() == [60] * 4
    assert found.score == pytest.approx(found.frame["aocc"].mean())
    assert [*found.by_problem.columns] == ["candidate", "cma-es", "random-search"]


def test_objects_are_taken_and_score_as_their_source_does(judge):
    def search(objective, rng):
        while True:
            objective(objective.initial(3))

    assert judge(search).score == judge(FUNCTION).score


def test_the_error_bar_is_that_of_the_mean_over_seeds_on_fixed_problems(judge):
    found = judge(FUNCTION)
    pairs = found.frame.groupby("problem")["aocc"].apply(np.array)
    assert found.error_bar == pytest.approx(np.sqrt(sum(np.var(pair, ddof=1) / 2 for pair in pairs)) / 2)


def test_the_score_is_the_aocc_of_the_analysis(judge):
    one = bench.solve(TRAIN[0], "random-search", budget=60, seed=1)
    optimum = bench.load_problem(TRAIN[0]).optimum
    from bench.analysis import aocc
    from bench.analysis.target_sets import area_over_curve

    frame = judge(FUNCTION).frame.head(1).assign(problem="p", optimizer="o", trial=0)
    table = aocc(frame, {("p", "o", 0): one.trace}, {"p": optimum}, 60)
    assert table["aocc"][0] == area_over_curve(one.trace, optimum, 60)[0]


@pytest.mark.parametrize(
    ("source", "error"),
    [
        ("def f(objective, rng):\n    return [1][7]\n", "line 2: IndexError: list index out of range (return [1][7])"),
        ("x = 1\nfor for\n", "line 2: SyntaxError: invalid syntax (<candidate>, line 2) (for for)"),
        ("import nothing_of_that_name\n", "line 1: ModuleNotFoundError: No module named 'nothing_of_that_name' "),
        ("x = 1\n", "BenchError: the source defines no optimizer"),
        ("def f(objective, rng):\n    pass\n", "RuntimeError: the optimizer returned without a single evaluation"),
        ("import os\ndef f(objective, rng):\n    os._exit(3)\n", "its process ended with exit code 3"),
        ("raise SystemExit\n", "line 1: SystemExit: no message (raise SystemExit)"),
    ],
)
def test_a_failed_candidate_scores_0_with_the_line_at_fault_and_costs_no_other(judge, source, error):
    failed, sound = judge.map([source, FUNCTION])
    assert failed.score == 0 < LEAST <= sound.score
    assert failed.error.startswith(error)
    assert failed.feedback.startswith("Score 0, as it failed: ")
    assert sound.error == ""


def test_a_broad_except_gains_nothing_at_the_end_of_the_budget(judge):
    source = """
def f(objective, rng):
    for _ in range(200):
        try:
            objective(objective.initial(1))
        except:
            pass
"""
    found = judge(source)
    assert found.error == ""
    assert set(found.frame["nfev"]) == {60}


@pytest.mark.slow
def test_an_endless_candidate_ends_at_the_time_limit():
    with Evaluator(TRAIN[0], budget=20, timeout=0.5, n_jobs=1, sandbox=False) as judge:
        judge(FUNCTION)
        found = judge("while True:\n    pass\n")
        assert (found.score, found.error) == (0, "stopped after 0.5 s, the limit of a trial")


def test_feedback_is_short_and_compares_with_the_baselines(judge):
    found = judge(CALLED)
    assert found.feedback.startswith(f"AOCC {found.score:.3f} ± ")
    assert "cma-es" in found.feedback
    assert "Used 100% of the evaluations." in found.feedback
    long = judge("def f(objective, rng):\n    raise ValueError('word ' * 50)\n")
    assert max(len(each.feedback.split()) for each in (found, long)) <= LONGEST


def test_the_final_is_a_test_once_and_counts(judge):
    judge(CALLED)
    failed = str(judge.final("def f(objective, rng):\n    1 / 0\n", trials=3))  # which costs no problem
    assert failed == "It failed: line 2: ZeroDivisionError: division by zero (1 / 0)"
    first, second = (judge.final(CALLED, trials=3) for _ in range(2))
    assert first.table["rival"].tolist() == ["cma-es", "random-search"]
    assert (first.finals, second.finals) == (0, 1)
    assert first.judged == second.judged > 0
    assert "spent" not in str(first)
    assert "had been used 1 time before: they are spent" in str(second)
    assert f"{first.judged} candidate" in str(first)


def test_problems_of_train_are_not_held_out():
    with pytest.raises(BenchError, match="problems of train cannot be held out for the final: classical-ackley-d2-i1"):
        Evaluator(TRAIN, TRAIN[1], sandbox=False)
    with pytest.raises(BenchError, match="there are no held-out problems"), Evaluator(TRAIN, sandbox=False) as judge:
        judge.final(FUNCTION)


@pytest.mark.slow
def test_an_optimum_that_is_unknown_or_beaten_is_said():
    unknown = FunctionProblem(lambda x: x[0] ** 2, [-1.0], [1.0], name="unknown")
    beaten = FunctionProblem(lambda x: x[0] ** 2, [-1.0], [1.0], name="beaten", optimum=5.0)
    with Evaluator([unknown, beaten], budget=20, n_jobs=1, sandbox=False) as judge:
        said = " ".join(judge(FUNCTION).notes)
    assert "The optimum of unknown is unknown" in said
    assert "beaten" in said


def test_clients_are_given_what_they_take(judge, tmp_path):
    scores = []
    solution = SimpleNamespace(code=FUNCTION, set_scores=lambda *given: scores.append(given))
    assert judge.llamea(solution) is solution
    solution.code = "1 / 0\n"
    judge.llamea(solution, "logger")
    assert scores[0][0] > 0
    assert scores[0][2] is None
    assert (scores[1][0], str(scores[1][2])) == (0, "line 1: ZeroDivisionError: division by zero (1 / 0)")
    path = tmp_path / "program.py"
    path.write_text(FUNCTION)
    answer = judge.evaluate(path)
    assert answer["combined_score"] == scores[0][0]
    assert [*answer["artifacts"]] == ["feedback"]
    judge.log(tmp_path / "runs.jsonl")
    last = json.loads((tmp_path / "runs.jsonl").read_text().splitlines()[-1])
    assert last["score"] == scores[0][0]


def test_a_closed_one_says_so():
    with Evaluator(TRAIN[0], budget=20, sandbox=False) as closed:
        pass
    with pytest.raises(BenchError, match="the evaluator is closed"):
        closed(FUNCTION)


@pytest.mark.parametrize(
    "deed",
    [
        "import gc\n    [setattr(t, 'fun', -1e9) for t in gc.get_objects() if type(t).__name__ == 'Objective']",
        "import sys\n    f = sys._getframe(1).f_locals['objective']\n    f._compute = lambda x: x[:, 0] * 0 - 1e9",
        "objective._nfev = 0\n    objective._limit = objective._budget = 10**6\n    objective.fun = -1e9",
        "objective(objective.upper * float('nan'))\n    objective(objective.upper + 1)",
    ],
    ids=["gc", "frames", "attributes", "nan"],
)
def test_no_deed_of_a_candidate_raises_its_score(judge, deed):
    middle = "def f(objective, rng):\n    objective((objective.lower + objective.upper) / 2.1)\n"
    assert judge(f"{middle}    {deed}\n").score <= judge(middle).score


def test_it_is_not_sent_to_other_processes(judge):
    with pytest.raises(BenchError, match="parallel_backend='threading'"):
        pickle.dumps(judge)


def test_without_bubblewrap_a_sentence_says_what_to_install(monkeypatch):
    monkeypatch.setattr("shutil.which", lambda name: None)
    with pytest.raises(BenchError, match=r"in a sandbox: bubblewrap .* apt install bubblewrap.* or say sandbox=False"):
        Evaluator(TRAIN[0], budget=20)


def test_in_the_sandbox_the_score_is_the_same_and_no_file_is_reached(judge, tmp_path):
    try:
        bubblewrap.find()
    except BenchError as error:
        pytest.skip(str(error))
    secret = tmp_path / "secret"
    secret.write_text("x")
    thief = f"open({str(secret)!r})\n{FUNCTION}"
    with Evaluator(TRAIN, budget=60, timeout=60, n_jobs=1) as safe:
        sound, failed = safe.map([FUNCTION, thief])
    assert sound.score == judge(FUNCTION).score
    assert failed.error.startswith("line 1: FileNotFoundError")
