"""Points that are known before a search: read, checked, handed to each optimizer first, and no bit else."""

import numpy as np
import pytest

from bench import BenchError, FunctionProblem, Objective, Study, load_results, run, solve
from bench.execution.verify import verify
from bench.study.initial import known_points

BOX = [(-5, 5)] * 2
KNOWN = [[4.0, 4.0], [0.5, -0.5]]


def sphere(x):
    return (x**2).sum()


def points(optimizer, budget=60, **settings):
    """Return the points of a run in order."""
    seen = []
    solve(sphere, optimizer, bounds=BOX, budget=budget, on_evaluation=lambda n, x, *_: seen.append(x), **settings)
    return np.array(seen)


@pytest.mark.parametrize("name", ["gwo", "random-search", "alo", "goa", "da", "scipy:differential_evolution"])
def test_a_population_begins_with_known_points_and_the_rest_is_random_as_before(name):
    with_them, without = points(name, initial=KNOWN)[:6], points(name)[:6]
    np.testing.assert_allclose(with_them[:2], KNOWN, rtol=1e-14)  # scipy scales them to the unit cube and back
    assert with_them[2:].tolist() == without[2:].tolist()


@pytest.mark.parametrize("name", ["cma-es", "bipop-cma-es", "scipy:dual_annealing"])
def test_a_search_from_one_point_starts_at_the_best_known_one(name):
    seen = points(name, initial=KNOWN)
    assert seen[:2].tolist() == KNOWN
    if name.startswith("scipy"):
        assert seen[2].tolist() == KNOWN[1]
    else:  # a generation around it
        assert np.linalg.norm(seen[2:8].mean(axis=0) - KNOWN[1]) < np.linalg.norm(seen[2:8].mean(axis=0) - KNOWN[0])


def test_they_are_handed_out_once_whatever_is_asked_for():
    problem = FunctionProblem(sphere, [-5, -5], [5, 5])
    problem.initial_points = np.array(KNOWN)
    first = Objective(problem, 9, np.random.default_rng(0))
    drawn = np.concatenate([first.initial(1), first.initial(3), first.initial(1)])
    assert drawn[:2].tolist() == KNOWN
    assert not (drawn[2:, np.newaxis] == np.array(KNOWN)).all(axis=2).any()
    assert first.nfev == 0
    assert first.start_point().shape == (2,)
    assert first.nfev == 0


def test_a_csv_file_has_a_point_in_each_line(tmp_path):
    (tmp_path / "designs.csv").write_text("\ufeffx1, x2\n4.0, 4.0\n\n0.5, -0.5\n", encoding="utf-8")
    assert known_points(str(tmp_path / "designs.csv")) == [["x1", "x2"], *KNOWN]
    (tmp_path / "one.csv").write_text("4.0,4.0")
    assert known_points(tmp_path / "one.csv") == [[4.0, 4.0]]
    for broken in ("x1,x2\n4.0\n", "x1;x2\n4.0;4.0\n", "4.0,4.0\n1,none\n", "x1,x2\n"):
        (tmp_path / "broken.csv").write_text(broken)
        with pytest.raises(BenchError, match="'initial' must be a list of points of one dimension"):
            known_points(tmp_path / "broken.csv")


def test_names_over_the_columns_of_a_file_say_which_variables_they_are(tmp_path):
    (tmp_path / "designs.csv").write_text("x2,x1\n1,2\n3,4\n")
    problem = {"name": "classical-sphere-d2-i1", "initial": str(tmp_path / "designs.csv")}
    (tmp_path / "s.toml").write_text(
        Study.from_dict({"name": "s", "problems": [problem], "optimizers": ["gwo"]}).to_toml()
    )
    found = Study.load(tmp_path / "s.toml").problem("classical-sphere-d2-i1").initial_points
    assert found.tolist() == [[2.0, 1.0], [4.0, 3.0]]


@pytest.mark.parametrize(
    ("initial", "sentence"),
    [
        ([], "'initial' must be a list of points of one dimension"),
        ([[1.0], [1.0, 2.0]], "'initial' must be a list of points of one dimension"),
        ([[float("nan"), 1.0]], "'initial' must be a list of points of one dimension"),
        ([[1.0]], "a point of 'initial' has 1 numbers, and the problem has 2 variables"),
        ([[1.0, 6.0]], "the point [1.0, 6.0] of 'initial' lies outside the box"),
        ([["x2", "b"], [1.0, 2.0]], "the columns of 'initial' are x2, b, and the variables are x1, x2"),
        ("no.csv", "the points in no.csv cannot be read: No such file or directory"),
    ],
)
def test_points_that_cannot_be_are_one_sentence(initial, sentence, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    problem = {"name": "classical-sphere-d2-i1", "initial": initial}
    with pytest.raises(BenchError) as caught:
        Study.from_dict({"name": "s", "problems": [problem], "optimizers": ["gwo"]}).dimensions()
    assert sentence in str(caught.value)


def test_a_study_begins_with_them_ends_at_a_target_and_its_trials_repeat_apart(tmp_path):
    problem = {"name": "classical-sphere-d2-i1", "initial": KNOWN}
    optimizers = [{"name": "gwo", "agents": 6}, {"name": "scipy:direct"}]
    settings = {"name": "s", "trials": 1, "budget": 400, "final_target": 1e-2, "optimizers": optimizers}
    study = Study.from_dict(settings | {"problems": [problem]})
    (tmp_path / "s.toml").write_text(study.to_toml())
    assert Study.load(tmp_path / "s.toml") == study
    outcome = run(study, tmp_path / "out", n_jobs=1, verify=False)
    assert outcome.unasked == ["scipy:direct"]
    frame = load_results(tmp_path / "out")
    assert set(frame["stop"]) == {"target"}
    assert (frame["precision"] <= 1e-2).all()
    assert (frame["nfev"] < 400).all()
    verified = verify(tmp_path / "out", n_jobs=1)
    assert (verified.trials, verified.different) == (2, {})
    assert Study.from_dict(settings | {"problems": [problem["name"]]}).identity() != study.identity()
