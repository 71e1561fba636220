"""Comparisons from Python alone: what is run, where it is kept, what continues it, and what is said of mistakes."""

from dataclasses import dataclass
from pathlib import Path

import pytest

import bench
from bench import BenchError, FunctionProblem, Optimizer, Results, compare
from tests.bench.made import Heard


@dataclass(frozen=True)
class Halving(Optimizer):
    """Moves half the way to a random point where that is better."""

    share: float = 0.5

    def minimize(self, objective, rng):
        x = objective.initial(1)
        f = objective(x)
        while True:
            y = x + self.share * (objective.initial(1) - x)
            g = objective(y)
            x, f = (y, g) if g < f else (x, f)


def draw(objective, rng):
    while True:
        objective(objective.initial(1))


def valley(scale=1.0, name="valley"):
    return FunctionProblem(lambda x: scale * ((x - 0.25) ** 2).sum(), [-1.0] * 2, [1.0] * 2, name=name)


def stored(results):
    return results.frame.set_index(["problem", "optimizer", "trial"])["fun"]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("comparison") / "kept"


@pytest.fixture(scope="module")
def results(place):
    return compare([valley()], [Halving, draw], trials=2, budget="5 * d", output=place, n_jobs=1)


def test_functions_and_classes_are_compared_in_one_call(results):
    assert isinstance(results, Results)
    assert results.frame.groupby("optimizer")["status"].apply(list).to_dict() == {
        "Halving": ["ok", "ok"], "draw": ["ok", "ok"]
    }  # fmt: skip
    assert set(results.frame["nfev"]) == {10}
    assert [entry.name for entry in results.study.optimizers] == ["python:Halving", "python:draw"]
    again = bench.solve(valley(), Halving, budget=10, seed=int(results.frame["seed"][0]))
    assert again.fun == results.frame["fun"][0]


def test_without_an_output_the_same_comparison_goes_on_and_another_gets_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    settings = {"budget": 4, "n_jobs": 1, "verify": False}
    made = []
    first = compare(valley(), draw, trials=1, **settings)
    heard = Heard(lambda trial, row: made.append(trial.number))
    again = compare(valley(), draw, trials=2, progress=heard, **settings)
    other = compare(valley(), Halving, trials=1, **settings)
    assert [each.paths for each in (first, again, other)] == [
        [Path("results/runs") / name] for name in ("comparison", "comparison", "comparison-2")
    ]
    assert made == [1]
    kept = again.save(tmp_path / "kept")
    assert stored(Results(kept)).equals(stored(again))
    with pytest.raises(BenchError, match="is not empty; give a new folder"):
        again.save(tmp_path / "kept")


def test_an_optimizer_that_cannot_be_loaded_is_named_and_costs_no_other_one(tmp_path):
    (tmp_path / "broken.py").write_text("class Mine(:\n    pass\n")
    broken = f"{tmp_path / 'broken.py'}:Mine"
    with pytest.warns(UserWarning, match=r"optimizer .*broken.py:Mine is left out, .*: SyntaxError.*line 1") as said:
        found = compare(valley(), [draw, broken], trials=1, budget=4, output=tmp_path / "out", n_jobs=1, verify=False)
    assert len(said) == 1
    assert found.frame["optimizer"].tolist() == ["draw"]
    with pytest.raises(BenchError, match="SyntaxError"):
        compare(valley(), broken, trials=1, budget=4, output=tmp_path / "none", n_jobs=1)


def test_results_show_the_verdict_and_draw_themselves(results):
    page, text = results._repr_html_(), str(results)
    for label in ("Halving", "draw", "chance"):
        assert label in page
        assert label in text
    assert text.splitlines()[0] in page
    assert results.plot.chances().lines
    assert results.plot.values().get_yticklabels()
    assert results.plot.convergence("valley").lines


def fails(objective, rng):
    objective(objective.initial(1))
    raise RuntimeError("no luck")


@pytest.mark.parametrize(
    ("problems", "optimizers", "settings", "sentence"),
    [
        ([valley()], [draw], {"budget": 0}, "study to compare: 'budget' must be a whole number from 1 to 1e+15"),
        ([valley()], [draw], {"n_jobs": 0}, "the number of jobs must be a whole number from 1 to 1000, or -1"),
        ([], [draw], {}, "needs at least one [[problems]] table with a name, or a list of names as problems"),
        (3, draw, {}, "needs at least one [[problems]] table"),
        (
            [FunctionProblem(lambda x: None, [0], [1])],
            [draw],
            {},
            "a function must return one number for a point, not N",
        ),
        ([valley()], [fails], {}, "every trial failed, the first one fails on valley, trial 0: RuntimeError: no luck"),
    ],
)
@pytest.mark.sampled(2)
def test_a_mistake_is_one_sentence(problems, optimizers, settings, sentence, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BenchError) as caught:
        compare(problems, optimizers, **{"trials": 1, "budget": 3, "n_jobs": 1, "verify": False} | settings)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)
