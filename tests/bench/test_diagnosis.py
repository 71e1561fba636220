"""Centre bias: an optimizer that shrinks to the centre is caught, one that does not is cleared."""

from dataclasses import dataclass

import numpy as np
import pytest

from bench import BenchError, Optimizer, Results, Study, diagnosis, load_optimizer, run
from bench.diagnosis import FLOOR, FUNCTIONS, LIMIT, SHIFT, _problem, centre_bias, diagnose
from bench.folder import Folder


@dataclass(frozen=True)
class Shrinking(Optimizer):
    """Draws ever closer to the centre, whatever it sees."""

    def minimize(self, objective, rng):
        middle, size = (objective.lower + objective.upper) / 2, 1.0
        while True:
            objective(middle + size * (objective.initial(1000) - middle))
            size *= 0.1


@dataclass(frozen=True)
class Raising(Optimizer):
    """Fails at once."""

    def minimize(self, objective, rng):
        raise ZeroDivisionError("boom")


def test_a_method_that_shrinks_to_the_centre_is_biased():
    found = centre_bias(Shrinking(), dimension=3, runs=2)
    assert not found.passed
    assert found.figure > 1e6
    assert "above the limit" in found.finding


def test_random_search_is_not():
    found = centre_bias(load_optimizer("random-search"), dimension=3, runs=5)
    assert found.passed
    assert 1 / LIMIT < found.figure < LIMIT


def test_gwo_is_biased_and_the_seed_repeats_the_figure():
    gwo = load_optimizer("gwo", agents=30)
    found = centre_bias(gwo, runs=2)
    assert not found.passed
    assert centre_bias(gwo, runs=2) == found
    assert centre_bias(gwo, runs=2, seed=1) != found


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_has_its_optimum_where_it_is_said_to_be(name):
    for shift in (0.0, SHIFT * 200):
        problem = _problem(name, FUNCTIONS[name], 5, shift)
        assert problem.evaluate(np.full((1, 5), shift))[0] == pytest.approx(0.0, abs=FLOOR)
        around = np.random.default_rng(0).uniform(-100, 100, (2000, 5))
        assert problem.evaluate(around).min() > 0


def test_a_failing_optimizer_is_named_with_its_error():
    with pytest.raises(BenchError, match="failed on sphere: ZeroDivisionError: boom"):
        centre_bias(Raising())


def test_a_folder_keeps_the_diagnoses_of_its_optimizers(small_study, tmp_path, monkeypatch):
    monkeypatch.setattr(diagnosis, "FUNCTIONS", {"sphere": FUNCTIONS["sphere"]})
    run(small_study.override(trials=1), tmp_path / "out", n_jobs=1)
    assert Results(tmp_path / "out").checks == {}
    found, failed = diagnose(Folder(tmp_path / "out"), n_jobs=1)
    assert failed == {}
    assert list(found) == ["hill-climber", "scatter", "early"]
    assert Results(tmp_path / "out").checks == {
        label: [each.as_dict() for each in those] for label, those in found.items()
    }
    (tmp_path / "out" / "checks.json").write_text('{"early": [{"check": 3}], "scatter": 5}')
    assert Results(tmp_path / "out").checks == {"early": []}


def test_an_optimizer_that_fails_costs_the_others_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(diagnosis, "FUNCTIONS", {"sphere": FUNCTIONS["sphere"]})
    entries = [{"name": "faulty"}, {"name": "scatter"}]
    study = {"name": "s", "trials": 1, "budget": 40, "problems": [{"name": "sphere-3"}], "optimizers": entries}
    run(Study.from_dict(study), tmp_path / "out", n_jobs=1)
    monkeypatch.setattr(
        "bench.study.Study.optimizer", lambda self, label: Raising() if label == "faulty" else Shrinking()
    )
    found, failed = diagnose(Folder(tmp_path / "out"), n_jobs=1)
    assert list(found) == list(Results(tmp_path / "out").checks) == ["scatter"]
    assert failed == {"faulty": "the optimizer failed on sphere: ZeroDivisionError: boom"}
